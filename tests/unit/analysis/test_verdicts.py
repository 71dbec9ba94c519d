"""What is said of goals, and of what faults do, in names."""

import math
from dataclasses import replace

import pytest

from mrsfi_runtime.analysis.tables import nearest_in_words
from mrsfi_runtime.analysis.weaknesses import (
    GoalVerdict,
    State,
    deed,
    detection,
    headline,
    owner_of,
    verdicts,
)
from mrsfi_runtime.causes.cause_set import Column
from mrsfi_runtime.causes.harvest import Harvest
from mrsfi_runtime.causes.mildest import ways
from mrsfi_runtime.causes.weakness import Detection, Known, Yardstick
from mrsfi_runtime.model.fault_types import Mode, Units
from mrsfi_runtime.model.faults import TimedFault
from mrsfi_runtime.record.observers import named_faults
from tests.support.search import outcome_of
from tests.support.weaknesses import weakness
from tests.support.world import paper_code

CODE = paper_code()


def said(fault, off=None):
    timed = TimedFault(fault, 10, 19, CODE.pool[fault].values)
    (named,) = named_faults(CODE.mission, CODE.pool, (timed,))
    return deed(CODE.mission, named, off)


@pytest.mark.parametrize(
    "fault", [f"f{number}" for number in (1, 2, 3, 4, 5, 8, 9, 10, 12, 15, 18, 20, 25, 26, 30)]
)
def test_what_a_fault_does_is_said_in_names(fault, approved):
    approved(said(fault))


def test_how_far_a_fixed_value_is_off_stands_in_the_place_of_the_value(approved):
    approved([said("f11"), said("f11", "51 off"), said("f11", "")])


def test_what_a_fault_does_is_said_in_the_units_of_the_model(approved):
    mission = replace(CODE.mission, distance_unit="m", time_unit="s", energy_unit="J")
    told = []
    for fault in ("f8", "f9", "f10", "f18"):
        timed = TimedFault(fault, 10, 19, CODE.pool[fault].values)
        (named,) = named_faults(mission, CODE.pool, (timed,))
        told.append(deed(mission, named))

    approved(told)


def test_every_mode_has_its_words():
    fault = CODE.pool["f11"]
    for mode in Mode:
        kind = replace(fault.kind, mode=mode)
        struck = replace(fault, kind=kind)
        assert owner_of(CODE.mission, struck)[0] == (2, "KAL r3")
        (named,) = named_faults(CODE.mission, CODE.pool, (TimedFault("f11", 1, 2, (1.0,) * 3),))
        assert "KAL's position" in deed(CODE.mission, replace(named, fault=struck))


@pytest.mark.parametrize(
    ("fault", "changed", "told"),
    [
        ("f3", {}, ((2, "KAL r3"), "gps position off")),
        ("f26", {}, ((0, "LEN r1"), "stopped")),
        ("f19", {}, ((3, "map"), "o2 random")),
        ("f7", {"target": "m1"}, ((3, "map"), "too low")),  # a message that carries no speed
    ],
)
def test_a_fault_is_told_by_whom_it_strikes_and_what_it_does(fault, changed, told):
    assert owner_of(CODE.mission, replace(CODE.pool[fault], **changed)) == told


def test_a_goal_whose_name_others_have_is_told_by_its_robots():
    goals = CODE.mission.goals

    assert CODE.mission.name_of(goals[0]) == "AvoidCollision"
    assert CODE.mission.name_of(goals[3]) == "GatherSamples · JEN"
    assert CODE.mission.name_of(replace(goals[0], name="")) == "g1"


@pytest.mark.parametrize(
    ("measure", "late"),
    [
        ("missed", (0, 1)),
        ("true", (7, 60, 0)),
        ("true", (0,)),
        ("missed", (0, 0)),
        ("true", (0, 5, math.inf, math.inf)),
        ("true", ()),
        ("believed", ()),
    ],
)
def test_the_worst_of_all_variants_is_told_and_in_how_many_it_is_so(measure, late, approved):
    found = Detection.of(dict(enumerate(late)))

    (way,) = ways([weakness("g1", measure, "f11", detection=found)])

    approved(detection(way, Units()))


@pytest.mark.parametrize(
    ("without", "measure"),
    [(0, "believed"), (3, "believed"), (3, "true")],
)
def test_what_breaks_without_faults_is_not_told_to_break_falsely_by_one(without, measure, approved):
    found = (weakness("g3", measure, "f4"),)
    yardstick = Yardstick((Column("g3", "true"),), (without,))
    known = Harvest(Known(CODE.mission), found, 0, {}, yardstick)

    told = verdicts(CODE.mission, CODE.pool, known)

    (said,) = (each.sentence for each in told if each.goal == "g3")
    approved(said)
    assert {each.unknown for each in told} == {"unknown: no bound"}  # nothing was drawn


def verdict(goal, state, *faults):
    way = ways([weakness(goal, "true", *faults)])[0] if faults else None
    return GoalVerdict(goal, goal, goal, state, way, 0, "", "", (), "")


HOLDS = verdict("g9", State.HOLDS)
ALONE = verdict("g1", State.FAILS, "f1")
JOINTLY = verdict("g2", State.FAILS, "f1", "f2")
VIOLATED = verdict("g3", State.VIOLATED, "f3")


@pytest.mark.parametrize(
    "found",
    [
        [HOLDS],
        [ALONE, HOLDS],
        [ALONE] * 3,
        [ALONE, JOINTLY, HOLDS],
        [ALONE, VIOLATED, HOLDS],
        [JOINTLY, HOLDS],
    ],
)
def test_the_headline_says_how_many_goals_break_and_under_how_many_faults(found, approved):
    approved(headline(found))


def test_what_held_was_neither_violated_nor_missed_and_has_a_margin(approved):
    outcome = replace(
        outcome_of(*(0,) * 6),
        true=(0, 3, 0, 0, 0, 0),
        missed=(0, 0, 9, 0, 0, 0),
        margins=((1.5, 7), (-0.5, 8), (2.0, 9), None, (30.0, 99), None),
    )

    told = nearest_in_words(CODE.mission, outcome)

    approved(told)
    approved(nearest_in_words(CODE.mission, replace(outcome, margins=None)))
