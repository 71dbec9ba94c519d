"""Metamodels with comments are read, and broken ones are refused with the line."""

from pathlib import Path

import pytest

from m2t.classes import class_files
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
name="Mission" | name="Missions" | <ecore:EPackage
name="mission" | name="m" | <ecore:EPackage
name="SensorType" | name="Kind" | #//SensorType
Ecore#//EDouble | Ecore#//EFloat | #//EFloat
lowerBound="1" | lowerBound="x" | lowerBound="x"
lowerBound="2" | lowerBound="-1" | lowerBound="-1"
containment="true" | contained="true" | missionArea
defaultValueLiteral="1.0" | defaultValueLiteral="?" | "tolerance" eT
ecore:EReference | ecore:EFeature | EFeature
name="DEPTH" | name="GPS_POSITION" | value="2"
name="servers" | name="eContents" | "eContents"
"robots" low | "robots" ordered="false" low | "robots"
name="center" | name="center" volatile="true" | "center"
name="center" | name="center" derived="true" | "center"
name="center" | name="the center" | "the center"
xsi:type="ecore:EEnum" | xsi:type="ecore:EDataType" | EDataType"
"#//Sensor" | "ecore:EClass faults.ecore#//Fault" | name="sensors"
name="Robot" | name="Größe" | "Größe"
abstract="true" | abstract="yes" | abstract="yes"
upperBound="-1" | upperBound="-2" | name="robots"
name="deadline" | name="deadline" defaultValueLiteral="1.5" | "deadline"
<eStructuralFeatures | <eOperations name="f"/><eStructuralFeatures | eOperations
<eClassifiers | <eSubpackages name="p"/><eClassifiers | eSubpackages
"""


@pytest.mark.parametrize(("old", "new", "place"), rows(BROKEN))
def test_broken_metamodel_is_refused_at_its_line(folder, old, new, place, refused):
    path = folder / MISSION_FILE
    edit(path, old, new)

    with refused(ModelError) as caught:
        read_metamodels(folder)

    assert f"{path}:{line_of(path, place)}: " in str(caught.value)


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
