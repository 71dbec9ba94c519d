"""Failure modes of the paper's mission, held to flights of their own."""

import re
from dataclasses import replace
from types import MappingProxyType

import pytest

from mrsfi_runtime.analysis.documents import HEADS, failure_modes
from mrsfi_runtime.causes.mildest import goal_weaknesses
from mrsfi_runtime.causes.weakness import Detection
from mrsfi_runtime.engine.flights import ReferenceEngine
from mrsfi_runtime.model.faults import FaultPool
from mrsfi_runtime.model.mission import Requirement
from tests.support.weaknesses import weakness
from tests.support.world import paper_code

CODE = paper_code(200)
STOP, BLIND = (
    next(fault.id for fault in CODE.pool if fault.type == name)
    for name in ("StopRobot", "DeactivateSensor")
)


RATINGS = {
    "occurrence": {"1": 0, "4": 0.1, "8": 0.5},
    "detection": {"never": 10, "late": 6},
}
UNRATED = MappingProxyType({})


def modes(found, chances=(), code=CODE, ratings=UNRATED, settled=()):
    given = dict(chances)
    pool = FaultPool("p", tuple(replace(f, likelihood=given.get(f.id)) for f in code.pool))
    record = ReferenceEngine(code, 1).record
    return failure_modes(code.mission, pool, goal_weaknesses(found), record, ratings, dict(settled))


def test_a_row_says_what_the_flight_shows():
    goal = CODE.mission.goals[0]
    found = Detection("never", 3, 2, 0, 0)
    form = weakness(goal.id, "true", STOP, start=100, finish=150, detection=found)

    (mode,) = modes([form, replace(form, column=form.column._replace(kind="missed"))])

    robot = CODE.pool[STOP].target
    name = CODE.mission.robots[CODE.mission.robot_index[robot]].name
    assert [each for each in HEADS if each in mode] == [*mode]
    assert mode["faults"] == STOP
    assert mode["item"] == f"the motion of {name} ({robot})"
    assert mode["failure mode"] == "StopRobot from tick 100 to 150"
    assert mode["local effect"].startswith("At tick 99, the commanded speed of ")
    assert f" ({robot}) was 0 instead of " in mode["local effect"]
    assert mode["end effect"] == f"{goal.name} ({goal.id})"
    assert mode["detection"] == "The CI does not detect it in 2 of 3 breaking variants"
    assert mode["effect class"] == "fails"
    assert (mode["weakness"], mode["likelihood"]) == (1, None)
    outcome = ReferenceEngine(CODE, 1).evaluate(form.witness)
    counts = outcome.believed[0], outcome.true[0], outcome.missed[0]
    assert mode["most ticks"] == max(counts)
    assert mode["ticks by measure"] == "believed {}, true {}, failed {}".format(*counts)


def test_the_likeliest_come_first_then_what_is_missed_then_what_breaks_longest():
    goals = CODE.mission.goal_ids
    found = [
        weakness(goals[0], "true", STOP),
        weakness(goals[1], "missed", BLIND),
        weakness(goals[2], "true", STOP, BLIND),
        weakness(goals[3], "true", BLIND),
    ]

    unknown = modes(found)
    known = modes(found, {STOP: 0.5, BLIND: 0.1}.items())
    partly = modes(found, {STOP: 0.5}.items())

    assert [mode["effect class"] for mode in unknown] == ["fails", *["is violated"] * 3]
    ticks = [mode["most ticks"] for mode in unknown[1:]]
    assert ticks == sorted(ticks, reverse=True)
    assert [mode["likelihood"] for mode in known] == pytest.approx([0.5, 0.1, 0.1, 0.05])
    assert known[1]["effect class"] == "fails"
    assert [mode["likelihood"] for mode in partly] == [0.5, None, None, None]
    assert all(
        "; " in each
        for each in (known[3]["item"], known[3]["failure mode"], known[3]["local effect"])
    )


def rated(*given, **fields):
    """Return the code with severities of goals, in model order, and with fields of the first."""
    goals = [replace(each, severity=n) for each, n in zip(CODE.mission.goals, given, strict=False)]
    goals[0] = replace(goals[0], **fields)
    required = (Requirement("R1", "first"), Requirement("R2", "second"))
    goals += CODE.mission.goals[len(given) :]
    return replace(CODE, mission=replace(CODE.mission, goals=tuple(goals), requirements=required))


def test_severe_ones_come_first_then_those_that_nobody_detects_and_false_alarms_have_no_severity():
    goals, words = CODE.mission.goal_ids, ("in time", "late", "never")
    by = [Detection(worst, 1, worst == "never", worst == "late", 0) for worst in words]
    found = [
        weakness(goals[0], "believed", STOP),
        *(
            weakness(goal, "true", STOP, detection=each)
            for goal, each in zip(goals[1:4], by, strict=True)
        ),
        weakness(goals[4], "true", STOP, detection=by[0]),
    ]

    rows = modes(found, {STOP: 0.2}.items(), rated(10, 7, 7, 7, 8), RATINGS)

    assert [row["weakness"] for row in rows] == [5, 4, 3, 2, 1]
    assert [row["S"] for row in rows] == [8, 7, 7, 7, None]
    assert [row["O"] for row in rows] == [4] * 5
    assert [row["D"] for row in rows] == [None, 10, 6, None, None]
    assert [row["RPN"] for row in rows] == [None, 280, 168, None, None]
    assert rows[-1]["effect class"] == "is violated in belief only (a false alarm)"


def test_what_neither_model_nor_team_says_is_empty():
    (row,) = modes([weakness(CODE.mission.goal_ids[0], "true", STOP)])

    empty = {name for name in HEADS if row.get(name) in ("", None)}
    assert empty == {
        *("requirement", "S", "O", "D", "RPN", "mildest variant", "recommended action"),
        *("owner", "status", "reference", "integrity level", "likelihood"),
    }


def test_a_row_has_what_model_and_team_say():
    goal = CODE.mission.goal_ids[0]
    code = rated(9, requirements=("R2", "R1"), integrity_level="ASIL B", severity=9)
    code = replace(
        code, pool=FaultPool("p", tuple(replace(f, reference="FM-1") for f in code.pool))
    )

    (row,) = modes([weakness(goal, "true", STOP)], code=code, settled={1: {"owner": "=x"}}.items())

    assert row["requirement"] == "R1: first; R2: second"
    assert (row["S"], row["integrity level"], row["reference"]) == (9, "ASIL B", "FM-1")
    assert row["owner"] == "=x"
    assert f"({goal})" in row["function"]
    assert re.match(r"At tick \d+, the (true|believed) ", row["next effect"])
    assert row["evidence"].startswith("Of ")


@pytest.mark.parametrize(
    ("chance", "number"), [(None, None), (0.0, 1), (0.0999, 1), (0.1, 4), (0.7, 8), (1.0, 8)]
)
def test_a_likelihood_has_the_number_of_the_highest_threshold_that_it_reaches(chance, number):
    (row,) = modes([weakness("g1", "true", STOP)], {STOP: chance}.items(), ratings=RATINGS)

    assert row["O"] == number
