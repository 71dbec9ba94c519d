"""Identifiers, constants, the order of features, and tasks that remember something."""

import keyword
import re
import sys

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pyecore.ecore import EAttribute, EClass, EString

from m2t.metaclasses import PROGRESSING, constant, features, identifier, lineage, snake_case
from mrsfi_runtime.errors import ModelError
from mrsfi_runtime.kernel.goal_tasks.table import TASKS


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("r1", "r1"),
        ("R1", "r1"),
        ("Scout-1", "scout_1"),
        ("scout 1", "scout_1"),
        ("sensor.depth__2", "sensor_depth_2"),
        ("r1_", "r1"),
    ],
)
def test_id_becomes_lower_case_identifier(text, expected):
    assert identifier(text) == expected


@pytest.mark.parametrize(
    "text",
    ["", "1r", "_", "-", "class", "Class", "topics", "truth", "r\n1", "r1\n", "rö1", "a;b", 'x")'],
)
def test_id_that_cannot_be_a_name_is_refused(text, refused):
    with refused(ModelError):
        identifier(text)


@given(st.text())
def test_identifier_is_a_python_and_ros_name_or_refused(text):
    try:
        name = identifier(text)
    except ModelError:
        return
    assert re.fullmatch(r"[a-z]([a-z0-9]|_(?=[a-z0-9]))*", name)
    assert not keyword.iskeyword(name)
    assert identifier(name) == name


def test_refusal_of_a_huge_id_stays_short():
    with pytest.raises(ModelError) as caught:
        identifier("é" * 10_000_000)

    assert len(str(caught.value)) < 1000


def test_constant_is_the_identifier_in_upper_case():
    assert constant("Scout-1") == "SCOUT_1"


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("AvoidCollision", "avoid_collision"),
        ("StayWithinMissionArea", "stay_within_mission_area"),
        ("SufficientEnergy", "sufficient_energy"),
        ("GatherSamples", "gather_samples"),
        ("Patrol", "patrol"),
        ("FixedDistanceBetweenRobots", "fixed_distance_between_robots"),
        ("GPSTask", "gps_task"),
    ],
)
def test_class_name_becomes_snake_case(name, expected):
    assert snake_case(name) == expected


@pytest.fixture
def metaclasses():
    base = EClass("FaultType", abstract=True)
    middle = EClass("MessageFault", superclass=(base,), abstract=True)
    leaf = EClass("ZeroSpeed", superclass=(middle,))
    for owner, names in ((base, "ab"), (middle, "cd"), (leaf, "fe")):
        for name in names:
            owner.eStructuralFeatures.append(EAttribute(name, EString))
    return base, middle, leaf


def test_lineage_ends_with_the_class_itself(metaclasses):
    base, middle, leaf = metaclasses

    assert lineage(leaf) == (base, middle, leaf)


def test_features_are_in_metamodel_order_inherited_ones_first(metaclasses):
    leaf = metaclasses[2]

    assert [feature.name for feature in features(leaf)] == ["a", "b", "c", "d", "f", "e"]


def test_features_of_two_supertypes_come_in_the_order_of_the_supertypes():
    one, other = EClass("One"), EClass("Other")
    one.eStructuralFeatures.append(EAttribute("a", EString))
    other.eStructuralFeatures.append(EAttribute("b", EString))
    both = EClass("Both", superclass=(one, other))

    assert [feature.name for feature in features(both)] == ["a", "b"]


def test_a_progress_region_is_generated_for_tasks_whose_module_has_progress():
    remembering = {
        task.__name__ for task in TASKS if hasattr(sys.modules[task.__module__], "progress")
    }

    assert remembering == PROGRESSING
