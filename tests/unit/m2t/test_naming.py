"""Identifiers and constants."""

import keyword
import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from m2t.metaclasses import constant, identifier, snake_case
from mrsfi_runtime.errors import ModelError


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
