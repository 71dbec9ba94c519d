"""Metamodels are written as Eclipse writes them, and broken ones are refused with the line."""

from pathlib import Path
from typing import Any

import pytest
from pyecore.ecore import EAttribute, EClass, EPackage, EReference, EString
from pyecore.resources import URI, ResourceSet

from m2t.metamodels import (
    FAULTS_FILE,
    MISSION_FILE,
    load_metamodels,
    metamodel_folder,
    read_metamodels,
)
from m2t.write.ecore import dumps_metamodel
from mrsfi_runtime.errors import ModelError
from tests.support.models.copies import edit, line_of
from tests.support.own_metamodels import copy_metamodels
from tests.support.tables import rows

BY_ECLIPSE = Path(__file__).with_name("by_eclipse.ecore").read_text(encoding="utf-8")
"""Written by Eclipse EMF 2.43 for a metamodel that was scrambled by hand."""


def _loaded(path: Path) -> Any:
    return ResourceSet().get_resource(URI(str(path))).contents[0]


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return copy_metamodels(tmp_path).parent


def test_committed_metamodels_are_what_the_writer_writes():
    both = load_metamodels()
    folder = metamodel_folder()

    mission = dumps_metamodel(both.mission)
    faults = dumps_metamodel(both.faults, hrefs={both.mission: MISSION_FILE})

    assert mission == (folder / MISSION_FILE).read_bytes()
    assert faults == (folder / FAULTS_FILE).read_bytes()


def test_metamodels_that_pyecore_loaded_by_itself_are_written_alike():
    path = metamodel_folder() / MISSION_FILE

    assert dumps_metamodel(_loaded(path)) == path.read_bytes()


def test_everything_that_pyecore_loses_is_written(tmp_path):
    path = tmp_path / "rich.ecore"
    path.write_text(BY_ECLIPSE, encoding="utf-8")

    assert dumps_metamodel(_loaded(path)).decode("utf-8") == BY_ECLIPSE


def test_attributes_of_the_root_wrap_without_its_namespaces(tmp_path):
    long = "http://x/rich/very/long/namespace/that/goes/beyond/the/width/of/eighty/columns"
    path = tmp_path / "rich.ecore"
    text = BY_ECLIPSE.replace('nsURI="http://x/rich" nsPrefix', f'nsURI="{long}"\n    nsPrefix')
    path.write_text(text, encoding="utf-8")

    assert dumps_metamodel(_loaded(path)).decode("utf-8") == text


def test_package_made_by_script_has_defaults_of_ecore():
    robot = EClass("Robot")
    robot.eStructuralFeatures.append(EAttribute("name", EString))
    robot.eStructuralFeatures.append(EReference("next", robot))
    package = EPackage("p", nsURI="http://p", nsPrefix="p")
    package.eClassifiers.append(robot)

    string = "ecore:EDataType http://www.eclipse.org/emf/2002/Ecore#//EString"
    assert dumps_metamodel(package).decode("utf-8").splitlines()[3:-1] == [
        '  <eClassifiers xsi:type="ecore:EClass" name="Robot">',
        f'    <eStructuralFeatures xsi:type="ecore:EAttribute" name="name" eType="{string}"/>',
        '    <eStructuralFeatures xsi:type="ecore:EReference" name="next" eType="#//Robot"/>',
        "  </eClassifiers>",
    ]


def test_reference_to_an_unknown_metamodel_is_an_error():
    with pytest.raises(ModelError, match=r"refers to '//Identified' of another metamodel"):
        dumps_metamodel(load_metamodels().faults)


def test_metamodels_with_comments_load(folder):
    edit(folder / MISSION_FILE, "  <eClassifiers", "  <!-- robots --><?p i?>\n  <eClassifiers")

    both = read_metamodels(folder)

    assert dumps_metamodel(both.mission) == (metamodel_folder() / MISSION_FILE).read_bytes()


BROKEN = """
name="Mission" | name="Missions" | <ecore:EPackage | has no class Mission
name="mission" | name="m" | <ecore:EPackage | expected the name mission
name="SensorType" | name="Kind" | #//SensorType | '#//SensorType', which is no EEnum
Ecore#//EDouble | Ecore#//EFloat | #//EFloat | has type 'EFloat'; expected EString
lowerBound="1" | lowerBound="x" | lowerBound="x" | has lowerBound 'x'; expected -1 or
lowerBound="2" | lowerBound="-1" | lowerBound="-1" | has bounds -1 and -1
containment="true" | contained="true" | missionArea | has no attribute 'contained'
defaultValueLiteral="1.0" | defaultValueLiteral="?" | "tolerance" eT | has the default '?'
ecore:EReference | ecore:EFeature | EFeature | has xsi:type 'ecore:EFeature'
name="DEPTH" | name="GPS_POSITION" | value="2" | has the name of line
name="servers" | name="eContents" | "eContents" | a name that every element uses
"robots" low | "robots" ordered="false" low | "robots" | values would change places
name="center" | name="center" volatile="true" | "center" | do not keep its values
name="center" | name="center" derived="true" | "center" | do not keep its values
name="center" | name="the center" | "the center" | has name 'the center'; expected a letter
xsi:type="ecore:EEnum" | xsi:type="ecore:EDataType" | EDataType" | 'ecore:EDataType'
"#//Sensor" | "ecore:EClass faults.ecore#//Fault" | name="sensors" | which is no EClass
name="Robot" | name="Größe" | "Größe" | 'Größe'; expected a letter, then letters, digits
abstract="true" | abstract="yes" | abstract="yes" | 'yes'; expected true or false
upperBound="-1" | upperBound="-2" | name="robots" | '-2'; expected -1 or a whole number
name="deadline" | name="deadline" defaultValueLiteral="1.5" | "deadline" | expected a whole number
<eStructuralFeatures | <eOperations name="f"/><eStructuralFeatures | eOperations
    is an unknown element of
<eClassifiers | <eSubpackages name="p"/><eClassifiers | eSubpackages | is an unknown element of
"""


@pytest.mark.parametrize(("old", "new", "place", "message"), rows(BROKEN))
def test_broken_metamodel_is_refused_at_its_line(folder, old, new, place, message):
    path = folder / MISSION_FILE
    edit(path, old, new)

    with pytest.raises(ModelError) as caught:
        read_metamodels(folder)

    first = next(line for line in str(caught.value).splitlines() if message in line)
    assert first.startswith(f"{path}:{line_of(path, place)}: ")


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ('name="Stay" eSuperTypes="#//GoalTask"', 'name="Stay" eSuperTypes="#//Stay"'),
        ('name="GoalTask"', 'name="GoalTask" eSuperTypes="#//GoalTask"'),
    ],
)
def test_class_that_inherits_from_itself_is_refused(folder, old, new):
    edit(folder / MISSION_FILE, old, new)

    with pytest.raises(ModelError, match="inherits from itself"):
        read_metamodels(folder)


def test_missing_metamodel_is_refused(tmp_path):
    with pytest.raises(ModelError, match=r"mission.ecore:1: mission.ecore cannot be read"):
        read_metamodels(tmp_path)
