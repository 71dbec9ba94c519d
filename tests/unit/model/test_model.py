"""Missions, units, what faults touch, and which timed faults are admitted."""

from dataclasses import replace
from fractions import Fraction
from math import inf, nan

import numpy as np
import pytest

from mrsfi_runtime.errors import SpecificationError
from mrsfi_runtime.kernel.goal_tasks.avoid_collision import AvoidCollision
from mrsfi_runtime.kernel.goal_tasks.gather_samples import GatherSamples
from mrsfi_runtime.kernel.goal_tasks.patrol import Patrol
from mrsfi_runtime.kernel.goal_tasks.stay import Stay
from mrsfi_runtime.kernel.goal_tasks.track import Track
from mrsfi_runtime.kernel.goal_tasks.visit import Visit
from mrsfi_runtime.model.fault_types import Field, Range, Units
from mrsfi_runtime.model.faults import (
    LAST,
    MOST,
    Event,
    Fault,
    FaultPool,
    Gate,
    TimedFault,
    Trigger,
    timed_fault,
    touched,
)
from mrsfi_runtime.model.mission import (
    Area,
    Battery,
    Coordinates,
    MotionSource,
    Requirement,
    starvation,
)
from mrsfi_runtime.record import database
from tests.support.fault_types import FAULT_TYPES
from tests.support.world import mission, paper_code, robot

NAMED = Units("m", "s", "J")
CODE = paper_code()
R3, S4 = CODE.mission.robot_index["r3"], CODE.mission.sensor_index["s4"]
GATE = Gate(CODE.mission, CODE.pool)
PLACE = (1.0, 2.0, 3.0)
HERE = Area("here", Coordinates(0.0, 0.0), 50.0)
FAR = Area("far", Coordinates(200.0, 0.0), 50.0)
NEXT = Area("next", Coordinates(100.0, 0.0), 50.0)
GATHER = GatherSamples(10, "a_depth")
BY_GATHERING = ("GatherSamples (g1)", "here", ["a"])


@pytest.mark.parametrize(
    ("max_speed", "fastest"), [(None, 8.0), (0.0, 0.0), (4.0, 4.0), (11.5, 11.5)]
)
def test_a_robot_reaches_its_greatest_speed_or_twice_the_nominal_one(max_speed, fastest):
    described = replace(robot("a", 0.0, 0.0, speed=4.0), max_speed=max_speed)

    assert described.fastest == fastest


def test_the_stakes_of_a_goal_are_its_requirements_in_one_line_its_severity_and_its_level():
    texts = {"R1": "No two\n\trobots touch.", "R2": "x" * 121, "R3": "of no goal"}
    required = tuple(Requirement(*each) for each in texts.items())
    plain, *others = CODE.mission.goals
    rated = replace(plain, requirements=("R2", "R1"), severity=8, integrity_level="ASIL B")
    described = replace(CODE.mission, requirements=required, goals=(rated, *others))

    stakes = described.stakes_of(rated.id)

    first = "requirement R1 (No two robots touch.), requirement R2 (" + "x" * 119
    assert stakes == f"{first}…), severity 8 of 10, ASIL B"
    assert CODE.mission.stakes_of(plain.id) == ""


def test_what_batteries_and_drives_add_up_to_is_the_same_on_every_python():
    """``sum`` makes 0.6 of these since Python 3.12, and made 0.6000000000000001 before."""
    numbers = (0.1, 0.2, 0.3)
    described = replace(
        robot("a", 0.0, 0.0),
        batteries=tuple(Battery(f"b{n}", "", n) for n in numbers),
        motion_sources=tuple(MotionSource(f"m{n}", "", n) for n in numbers),
    )

    assert described.total_energy == 0.6000000000000001
    assert described.energy_per_distance_unit == 0.6000000000000001


@pytest.mark.parametrize(
    ("measured", "unnamed", "named"),
    [
        (Range.TICKS, "12 ticks", "12 s"),
        (Range.PERCENT, "12 percent", "12 percent"),
        (Range.SHARE, "12", "12"),
        (Range.SPEED, "12 units per tick", "12 m per s"),
        (Range.ENERGY, "12 energy units", "12 J"),
        (Range.COUNT, "12 samples", "12 samples"),
        (Range.RATE, "12 samples per tick", "12 samples per s"),
        (Range.COST, "12 energy per sample", "12 J per sample"),
        (Range.X, "12", "12 m"),
        (Range.Z, "12", "12 m"),
    ],
)
def test_a_quantity_is_told_with_its_unit(measured, unnamed, named):
    assert Units().quantity(12.0, measured) == unnamed
    assert NAMED.quantity(12.0, measured) == named


def test_how_long_ticks_last_is_told_in_the_unit_of_time():
    assert [Units().ticks(n) for n in (1, 2)] == ["1 tick", "2 ticks"]
    assert [NAMED.ticks(n) for n in (1, 2)] == ["1 s", "2 s"]


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


def test_a_pool_with_a_prefix_has_it_before_the_ids_of_faults_and_triggers():
    waiting = Fault("f4.1", FAULT_TYPES["FixedSpeed"], "m7", (3.0,), trigger="bitten")
    triggers = (
        Trigger("bitten", Event.EFFECT, ("f4.1",)),
        Trigger("low", Event.VIOLATED, ("g3",), delay=2),
    )

    found = FaultPool("kept", (waiting, replace(waiting, trigger="")), triggers=triggers)

    assert found.with_prefix("a/") == FaultPool(
        "kept",
        (
            replace(waiting, id="a/f4.1", trigger="a/bitten"),
            replace(waiting, id="a/f4.1", trigger=""),
        ),
        triggers=(
            Trigger("a/bitten", Event.EFFECT, ("a/f4.1",)),
            Trigger("a/low", Event.VIOLATED, ("g3",), delay=2),
        ),
    )


def f8(delay):
    return [TimedFault("f8", 0, 9, (delay,))]


@pytest.mark.parametrize(
    "specification",
    [
        [TimedFault("f9", 100.5, 400, PLACE)],
        [TimedFault("f9", 100.0, 400, PLACE)],
        [TimedFault("f9", True, 400, PLACE)],
        [TimedFault("f9", np.True_, 400, PLACE)],
        [TimedFault("f9", "3", 400, PLACE)],
        [TimedFault("f9", None, 400, PLACE)],
        [TimedFault("f9", 100, inf, PLACE)],
        [TimedFault("f9", nan, 100, PLACE)],
        [TimedFault("f1", 9, 8)],
        [TimedFault("f1", -1, 8)],
        [TimedFault("f1", 0, LAST + 1)],
        f8(2.7),
        f8(-3),
        f8(float(LAST + 1)),
        f8("3"),
        f8(True),
        f8(None),
        f8(nan),
        f8(inf),
        f8(10**400),
        [TimedFault("f10", 0, 9, (1.001 * MOST,))],
        [TimedFault("f14", 0, 9, (-1e10,))],
        [TimedFault("f14", 0, 9, (-LAST - 2.0,))],
        [TimedFault("f24", 0, 9, (5.0, 4.0))],
        [TimedFault("f4", 0, 9)],
        [TimedFault("f1", 0, 9, (1.0,))],
        [TimedFault("f9", 0, 9, 1.0)],
        [("f1", 0, 9, (), "t", 1)],
        [TimedFault("f1", 0, 9, (), 7)],
        [TimedFault("f1", 0, 9, (), "low")],
        [("f9", 1)],
        [TimedFault(3, 0, 9)],
        [TimedFault(["f1"], 0, 9)],
        7,
        TimedFault("f1", 0, 9),
        [TimedFault("f33", 0, 9)],
        [TimedFault("f4", 0, 9, (1.0,)), TimedFault("f27", 9, 12)],
        [TimedFault("f1", 0, 9), TimedFault("f1", 5, 12)],
    ],
)
def test_what_makes_no_sense_is_refused(specification, refused):
    with refused(SpecificationError):
        GATE.admitted(specification)


def copies(*names: str) -> FaultPool:
    """Return a written specification of copies of f7, of a message that carries no speed."""
    fault = replace(CODE.pool["f7"], target="m1", start=0, finish=9)
    return FaultPool("written", tuple(replace(fault, id=name) for name in names))


@pytest.mark.parametrize("names", [("f7.1", "f7.2"), ("f7", "f7.1"), ("gone.1", "gone.2")])
def test_written_copies_of_one_fault_never_overlap_even_if_they_touch_nothing(names, refused):
    written = copies(*names)
    gate = Gate(CODE.mission, written, CODE.pool.by_id)

    with refused(SpecificationError):
        gate.admitted(written.written_specification())


@pytest.mark.parametrize("names", [("f7", "f6"), ("f7.1", "f6.1"), ("f7.a", "f7.b"), (".1", ".2")])
def test_written_faults_that_are_no_copies_of_one_may_overlap_where_they_touch_nothing(names):
    written = copies(*names)

    admitted = Gate(CODE.mission, written, CODE.pool.by_id).admitted(
        written.written_specification()
    )

    assert [timed.fault for timed in admitted] == [*names]


def test_faults_of_the_pool_are_no_copies_whatever_they_are_called():
    written = copies("pump.1", "pump.2")

    gate = Gate(CODE.mission, written, {"pump.1", "pump.2"})

    assert len(gate.admitted(written.written_specification())) == 2


def test_what_comes_out_is_of_pythons_own_kinds():
    asked = [
        TimedFault(np.str_("f8"), np.int64(10), np.int32(20), [np.int8(4)]),
        ("f10", 0, LAST, (Fraction(1, 2),)),
        TimedFault("f14", 0, 9, (3,)),
        TimedFault("f14", 10, 19, (-LAST - 1,)),
    ]

    admitted = GATE.admitted(asked)

    assert admitted == (
        TimedFault("f8", 10, 20, (4.0,)),
        TimedFault("f10", 0, LAST, (0.5,)),
        TimedFault("f14", 0, 9, (3.0,)),
        TimedFault("f14", 10, 19, (-(2.0**31),)),
    )
    kinds = {type(part) for timed in admitted for part in (*timed[:3], *timed.values)}
    assert kinds == {str, int, float}


def test_what_is_plain_already_stays_the_same_object():
    asked = (TimedFault("f4", 0, 8, (1.0,)), TimedFault("f27", 9, 12))

    assert [*map(id, GATE.admitted(asked))] == [*map(id, asked)]


def test_values_are_given_by_the_names_of_their_parameters(refused):
    fault = CODE.pool["f9"]

    timed = timed_fault("f9", fault.kind, 1, 2, {"NEW_Z": 3, "NEW_X": 1, "NEW_Y": 2})

    assert timed == TimedFault("f9", 1, 2, PLACE)
    with refused(SpecificationError):
        timed_fault("f9", fault.kind, 1, 2, {"NEW_W": 3})


@pytest.mark.parametrize("row", [["f9", 15.08, 20, []], ["f9", 1, 2, ["3"]], ["f9", 1, 2, [2e12]]])
def test_a_record_takes_and_gives_no_other_fault_than_it_was_given(row, refused):
    with refused(ValueError):
        database.specification([row])
    with refused(SpecificationError):
        database.specification_text([TimedFault(*row)])


def at(x, tolerance=3.0):
    return Visit(Coordinates(x, 0.0), tolerance, 90)


def told(*tasks):
    """Return what is said of the last goal of a mission with such tasks."""
    found = mission(*tasks, area=HERE)
    return starvation(found, found.goals[-1])


def said(*holders):
    """Return the words for goals that hold robots somewhere."""
    held = [
        f"{goal}, which reacts first, keeps {' and '.join(robots)} in area {area}"
        for goal, area, robots in holders
    ]
    return f"as {' and '.join(held)}" if held else ""


@pytest.mark.parametrize(
    ("tasks", "expected"),
    [
        ((GATHER, at(54.0)), [BY_GATHERING]),
        ((GATHER, at(53.0)), []),
        ((at(54.0), GATHER), []),
        ((at(54.0), at(200.0)), []),
        ((Patrol(HERE, 9), at(54.0)), [("Patrol (g1)", "here", ["a", "b"])]),
        ((Stay(HERE), Patrol(FAR, 9)), [("Stay (g1)", "here", ["a", "b"])]),
        ((Stay(HERE), Patrol(NEXT, 9)), []),
        ((Patrol(FAR, 9), GATHER), [("Patrol (g1)", "far", ["a"])]),
        ((Patrol(period=9, route=(HERE, FAR)), at(60.0)), []),
        ((Stay(HERE), Patrol(period=9, route=(HERE, FAR))), [("Stay (g1)", "here", ["a", "b"])]),
        ((GATHER, Track((Coordinates(0.0), Coordinates(54.0)), 3.0)), [BY_GATHERING]),
        ((GATHER, Track((Coordinates(0.0), Coordinates(53.0)), 3.0)), []),
        ((GATHER, Stay(FAR), at(120.0)), [BY_GATHERING, ("Stay (g2)", "far", ["a", "b"])]),
        ((GATHER, AvoidCollision(("a", "b"), ())), []),
    ],
)  # fmt: skip
def test_a_goal_starves_where_one_before_it_keeps_its_robots_elsewhere(tasks, expected):
    assert told(*tasks) == said(*expected)


def test_a_goal_of_other_robots_holds_nothing():
    found = mission(GATHER, at(54.0), area=HERE)
    other = replace(found.goals[1], members=("b",))

    assert starvation(replace(found, goals=(found.goals[0], other)), other) == ""
