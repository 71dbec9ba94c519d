"""What is said of goals, and of what faults do, in names."""

import math
import re
from dataclasses import replace

import pytest

from mrsfi_runtime.analysis.campaign_tables import nearest_in_words
from mrsfi_runtime.analysis.verdicts import (
    GoalVerdict,
    State,
    deed,
    headline,
    owner_of,
    verdicts,
)
from mrsfi_runtime.analysis.weaknesses import detection
from mrsfi_runtime.causes.counts import Column
from mrsfi_runtime.causes.harvest import Harvest
from mrsfi_runtime.causes.ways import ways
from mrsfi_runtime.causes.weakness import Detection, Known, Yardstick
from mrsfi_runtime.model.fault_types import Mode, Units
from mrsfi_runtime.model.faults import TimedFault
from mrsfi_runtime.record.named_faults import named_faults
from tests.support.search import outcome_of
from tests.support.weaknesses import weakness
from tests.support.world import paper_code

CODE = paper_code()


def said(fault, off=None):
    timed = TimedFault(fault, 10, 19, CODE.pool[fault].values)
    (named,) = named_faults(CODE.mission, CODE.pool, (timed,))
    return deed(CODE.mission, named, off)


@pytest.mark.parametrize(
    ("fault", "expected"),
    [
        ("f1", "LEN's pressure is switched on for 10 ticks"),
        ("f2", "JEN's position is held back for 5 ticks"),
        ("f3", "KAL's gps position is switched off for 10 ticks"),
        ("f4", "KAL's energy is reported 10 % too low for 10 ticks"),
        ("f5", "KAL's depth rate is reported 2 samples per tick too low for 10 ticks"),
        ("f8", "JEN's temperature samples come 200 ticks late for 10 ticks"),
        ("f9", "obstacle o5's place on the map sticks at (200, -450) for 10 ticks"),
        ("f10", "KAL's energy sticks at 150 energy units for 10 ticks"),
        (
            "f12",
            "KAL's gps position rate and depth rate stick at 120 samples per tick for 10 ticks",
        ),
        ("f15", "KAL's energy is reported 10 % too high for 10 ticks"),
        ("f18", "JEN's speed is reported 10 units per tick too high for 10 ticks"),
        ("f20", "KAL's energy is reported at random for 10 ticks"),
        ("f25", "KAL is set going for 10 ticks"),
        ("f26", "LEN is stopped for 10 ticks"),
        ("f30", "LEN's speed is reported as 0 for 10 ticks"),
    ],
)
def test_what_a_fault_does_is_said_in_names(fault, expected):
    assert said(fault) == expected


def test_how_far_a_fixed_value_is_off_stands_in_the_place_of_the_value():
    assert said("f11") == "KAL's position sticks at (1200, -800) for 10 ticks"
    assert said("f11", "51 off") == "KAL's position sticks 51 off for 10 ticks"
    assert said("f11", "") == "KAL's position sticks for 10 ticks"


def test_what_a_fault_does_is_said_in_the_units_of_the_model():
    mission = replace(CODE.mission, distance_unit="m", time_unit="s", energy_unit="J")
    told = []
    for fault in ("f8", "f9", "f10", "f18"):
        timed = TimedFault(fault, 10, 19, CODE.pool[fault].values)
        (named,) = named_faults(mission, CODE.pool, (timed,))
        told.append(deed(mission, named))

    assert told == [
        "JEN's temperature samples come 200 s late for 10 s",
        "obstacle o5's place on the map sticks at (200 m, -450 m) for 10 s",
        "KAL's energy sticks at 150 J for 10 s",
        "JEN's speed is reported 10 m per s too high for 10 s",
    ]


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
    ("measure", "late", "expected"),
    [
        ("missed", (0, 1), "detected late in 1 of 2 variants, by up to 1 tick"),
        ("true", (7, 60, 0), "detected late in 2 of 3 variants, by up to 60 ticks"),
        ("true", (0,), "detected in time in 1 of 1 variant"),
        ("missed", (0, 0), "detected in time in 2 of 2 variants"),
        ("true", (0, 5, math.inf, math.inf), "undetected in 2 of 4 variants"),
        ("true", (), "detection not recorded"),
        ("believed", (), "a false alarm of the CI"),
    ],
)
def test_the_worst_of_all_variants_is_told_and_in_how_many_it_is_so(measure, late, expected):
    found = Detection.of(dict(enumerate(late)))

    (way,) = ways([weakness("g1", measure, "f11", detection=found)])

    assert detection(way, Units()) == expected


@pytest.mark.parametrize(
    ("without", "measure", "expected"),
    [
        (
            0,
            "believed",
            "is only believed broken if KAL's energy is reported 10 % too low for 81 ticks; .+",
        ),
        (3, "believed", "is violated without any fault"),
        (3, "true", "is violated if KAL's energy is reported 10 % too low for 81 ticks; .+"),
    ],
)
def test_what_breaks_without_faults_is_not_told_to_break_falsely_by_one(without, measure, expected):
    found = (weakness("g3", measure, "f4"),)
    yardstick = Yardstick((Column("g3", "true"),), (without,))
    known = Harvest(Known(CODE.mission), found, 0, {}, yardstick)

    told = verdicts(CODE.mission, CODE.pool, known)

    (said,) = (each.sentence for each in told if each.goal == "g3")
    assert re.fullmatch(f"SufficientEnergy g3 {expected}", said)
    assert {each.unknown for each in told} == {"unknown: no bound"}  # nothing was drawn


def verdict(goal, state, *faults):
    way = ways([weakness(goal, "true", *faults)])[0] if faults else None
    return GoalVerdict(goal, goal, goal, state, way, 0, "", "", (), "")


HOLDS = verdict("g9", State.HOLDS)
ALONE = verdict("g1", State.FAILS, "f1")
JOINTLY = verdict("g2", State.FAILS, "f1", "f2")
VIOLATED = verdict("g3", State.VIOLATED, "f3")


@pytest.mark.parametrize(
    ("found", "expected"),
    [
        ([HOLDS], "Nothing was found that breaks a goal"),
        ([ALONE, HOLDS], "One of two goals fails, under one single fault"),
        ([ALONE] * 3, "All three goals fail, each under one single fault"),
        ([ALONE, JOINTLY, HOLDS], "Two of three goals fail, one of them under one single fault"),
        ([ALONE, VIOLATED, HOLDS], "Two of three goals break, each under one single fault"),
        ([JOINTLY, HOLDS], "One of two goals fails, under several faults together"),
    ],
)
def test_the_headline_says_how_many_goals_break_and_under_how_many_faults(found, expected):
    assert headline(found) == expected


def test_what_held_was_neither_violated_nor_missed_and_has_a_margin():
    outcome = replace(
        outcome_of(*(0,) * 6),
        true=(0, 3, 0, 0, 0, 0),
        missed=(0, 0, 9, 0, 0, 0),
        margins=((1.5, 7), (-0.5, 8), (2.0, 9), None, (30.0, 99), None),
    )

    told = nearest_in_words(CODE.mission, outcome)

    assert told == "Held: g1 by 1.5 at tick 7, g5 by 30 ticks at tick 99"
    assert nearest_in_words(CODE.mission, replace(outcome, margins=None)) == "Held: not recorded"
