"""What faults touch, and which conflict."""

from dataclasses import replace

import pytest

from mrsfi_runtime.errors import SpecificationError
from mrsfi_runtime.model.fault_types import Field
from mrsfi_runtime.model.faults import Fault, FaultPool, Gate, TimedFault, touched
from tests.support.fault_types import FAULT_TYPES
from tests.support.world import paper_code

CODE = paper_code()


R3, S4 = CODE.mission.robot_index["r3"], CODE.mission.sensor_index["s4"]


@pytest.mark.parametrize(
    ("message", "expected"),
    [
        ("m8", ((Field.POSITION, R3), (Field.SPEED, R3), (Field.ENERGY, R3))),
        ("m10", ((Field.COUNT, S4),)),  # of the sender's sensor of that type
    ],
)
def test_delay_and_block_touch_every_field_of_their_message(message, expected):
    for kind in ("DelayMessage", "BlockMessage"):
        assert touched(CODE.mission, Fault("late", FAULT_TYPES[kind], message, (5.0,))) == expected


def test_a_field_that_a_body_names_twice_is_touched_once():
    fault = Fault("late", FAULT_TYPES["DelayMessage"], "m8", (5.0,))
    doubled = (replace(goal, messages=_twice(goal)) for goal in CODE.mission.goals)
    mission = replace(CODE.mission, goals=tuple(doubled))

    Gate(mission, FaultPool("p", (fault,))).admitted([TimedFault("late", 0, 9, (5.0,))])

    assert touched(mission, fault) == touched(CODE.mission, fault)


def _twice(goal):
    """Return the messages of a goal, each field of which stands in its body twice."""
    return tuple(replace(message, body=message.body * 2) for message in goal.messages)


def test_conflicts_are_mutual_and_follow_the_property_not_the_message():
    table = Gate(CODE.mission, CODE.pool).conflicts()

    assert all(first in table[second] for first in table for second in table[first])
    energy_of_r3 = {"f4", "f10", "f15", "f20", "f27"}
    assert table["f4"] == energy_of_r3
    assert "f11" not in table["f2"]  # positions of two robots
    assert table["f1"] == {"f1"}


@pytest.mark.parametrize(
    ("type_name", "target"),
    [
        ("StopRobot", "r9"),
        ("ActivateSensor", "r1"),
        ("FixedObstacleCoordinates", "m1"),
        ("FixedSpeed", "o1"),
    ],
)
def test_a_target_that_the_mission_lacks_is_refused_by_name(type_name, target, refused):
    with refused(SpecificationError):
        touched(CODE.mission, Fault("odd", FAULT_TYPES[type_name], target))


def test_a_pool_without_windows_is_no_written_specification(refused):
    with refused(SpecificationError):
        CODE.pool.written_specification()


def test_a_written_specification_has_its_own_windows_and_values():
    fault = Fault("f4.1", FAULT_TYPES["FixedSpeed"], "m7", (3.0,), start=5, finish=7)

    assert FaultPool("found", (fault,)).written_specification() == (
        TimedFault("f4.1", 5, 7, (3.0,)),
    )
