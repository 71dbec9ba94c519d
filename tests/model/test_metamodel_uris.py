"""How metamodels may name one another and Ecore: as Eclipse writes it."""

import pytest

from m2t.classes import class_files
from m2t.metamodels import FAULTS_FILE, MISSION_FILE, load_metamodels, read_metamodels
from mrsfi_runtime.errors import ModelError
from tests.support.models.copies import edit
from tests.support.own_metamodels import copy_metamodels

ECORE = "http://www.eclipse.org/emf/2002/Ecore#//"
MISSION, FAULTS = "http://mrsfi.org/mission/1.0#//", "http://mrsfi.org/faults/1.0#//"

KNOWN = [ECORE[:-3], "Ecore.ecore", "mission.ecore", MISSION[:-3], "faults.ecore", FAULTS[:-3]]


@pytest.fixture
def folder(tmp_path):
    return copy_metamodels(tmp_path / "team" / "metamodels").parent


def rewrite(path, old, new):
    text = path.read_text(encoding="utf-8")
    assert old in text
    path.write_text(text.replace(old, new), encoding="utf-8")


@pytest.mark.parametrize(
    ("file", "old", "new"),
    [
        (FAULTS_FILE, "mission.ecore#//", MISSION),
        (FAULTS_FILE, "mission.ecore#//", "platform:/resource/team/metamodels/mission.ecore#//"),
        (FAULTS_FILE, "mission.ecore#//", "platform:/resource/elsewhere/model/mission.ecore#//"),
        (FAULTS_FILE, "mission.ecore#//", "platform:/plugin/org.mrsfi/model/mission.ecore#//"),
        (FAULTS_FILE, '"#//', f'"{FAULTS}'),
        (FAULTS_FILE, 'eType="#//', f'eType="ecore:EClass {FAULTS}'),
        (FAULTS_FILE, '"#//', '"faults.ecore#//'),
        (MISSION_FILE, '"#//', f'"{MISSION}'),
        (MISSION_FILE, ECORE, "platform:/plugin/org.eclipse.emf.ecore/model/Ecore.ecore#//"),
        (MISSION_FILE, ECORE, "platform:/resource/org.eclipse.emf.ecore/model/Ecore.ecore#//"),
    ],
)
def test_addresses_that_eclipse_writes_mean_the_same_metamodels(file, old, new, folder):
    rewrite(folder / file, old, new)

    both = read_metamodels(folder)

    assert class_files(both.packages) == class_files(load_metamodels().packages)


@pytest.mark.parametrize(
    ("file", "old", "uri"),
    [
        (FAULTS_FILE, "mission.ecore#//Goal", "http://mrsfi.org/mission/2.0"),
        (FAULTS_FILE, "mission.ecore#//Goal", "platform:/plugin/org.mrsfi/model/missions.ecore"),
        (FAULTS_FILE, "mission.ecore#//Goal", "other/mission.ecore"),
        (MISSION_FILE, f"{ECORE}EDouble", "http://www.eclipse.org/emf/2003/XMLType"),
        (MISSION_FILE, f"{ECORE}EDouble", "platform:/plugin/org.eclipse.emf.ecore/model/XML.ecore"),
    ],
)
def test_an_address_of_no_metamodel_is_named_as_the_cause(file, old, uri, folder, refused):
    edit(folder / file, old, f"{uri}#//{old.rpartition('/')[2]}")

    with refused(ModelError):
        read_metamodels(folder)


def test_a_name_that_no_metamodel_has_is_told_from_an_address(folder, refused):
    edit(folder / FAULTS_FILE, "mission.ecore#//Goal", f"{MISSION}Aim")

    with refused(ModelError):
        read_metamodels(folder)


@pytest.mark.parametrize(
    ("old", "new", "finding"),
    [
        ('name="Robot"', 'name="Ro bot"', "has name 'Ro bot'; expected a letter, .* [NameSyntax]"),
        ("<eLiterals name", '<eLiterals literal="dark red" name',
         "has literal 'dark red'; expected a letter, .* [NameSyntax]"),
        ('nsPrefix="mission"', 'nsPrefix="m-1"', "has nsPrefix 'm-1'; .* [NameSyntax]"),
        ('nsURI="http://mrsfi.org/mission/1.0"', 'nsURI=""', "has nsURI ''; .* [RequiredFeature]"),
        ('iD="true"', 'iD="yes"', "has iD 'yes'; expected true or false.* [EnumLiteral]"),
        ('lowerBound="1"', 'lowerBound="one"', "has lowerBound 'one'; .* [NumberSyntax]"),
    ],
)  # fmt: skip
def test_what_is_misspelt_is_told_by_a_rule_of_its_kind(old, new, finding, folder):
    edit(folder / MISSION_FILE, old, new)

    with pytest.raises(ModelError) as caught:
        read_metamodels(folder)

    start, _, end = finding.partition(".*")
    assert start in str(caught.value)
    assert end in str(caught.value)
