"""Metamodels with comments are read, and broken ones are refused with the line."""

from pathlib import Path

import pytest

from m2t.classes.generator import class_files
from m2t.metamodels import (
    MISSION_FILE,
    load_metamodels,
    read_metamodels,
)
from mrsfi_runtime.errors import ModelError
from tests.support.models.copies import edit, line_of
from tests.support.own_metamodels import copy_metamodels
from tests.support.tables import rows


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return copy_metamodels(tmp_path).parent


def test_metamodels_with_comments_load(folder):
    edit(folder / MISSION_FILE, "  <eClassifiers", "  <!-- robots --><?p i?>\n  <eClassifiers")

    both = read_metamodels(folder)

    assert class_files(both.packages) == class_files(load_metamodels().packages)


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
def test_class_that_inherits_from_itself_is_refused(folder, old, new, refused):
    edit(folder / MISSION_FILE, old, new)

    with refused(ModelError):
        read_metamodels(folder)


def test_missing_metamodel_is_refused(tmp_path, refused):
    with refused(ModelError):
        read_metamodels(tmp_path)
