"""Failure modes of the paper's mission, held to flights of their own."""

from dataclasses import replace

import pytest

from mrsfi_runtime.analysis.failure_modes import failure_modes
from mrsfi_runtime.causes.mildest import goal_weaknesses
from mrsfi_runtime.causes.weakness import Detection
from mrsfi_runtime.engine.flights import ReferenceEngine
from mrsfi_runtime.model.faults import FaultPool
from tests.support.weaknesses import weakness
from tests.support.world import paper_code

CODE = paper_code(200)
STOP, BLIND = (
    next(fault.id for fault in CODE.pool if fault.type == name)
    for name in ("StopRobot", "DeactivateSensor")
)


def modes(found, chances=()):
    given = dict(chances)
    pool = FaultPool("p", tuple(replace(f, likelihood=given.get(f.id)) for f in CODE.pool))
    return failure_modes(
        CODE.mission, pool, goal_weaknesses(found), ReferenceEngine(CODE, 1).record
    )


def test_a_row_says_what_the_flight_shows():
    goal = CODE.mission.goals[0]
    found = Detection("never", 3, 2, 0, 0)
    form = weakness(goal.id, "true", STOP, start=100, finish=150, detection=found)

    (mode,) = modes([form, replace(form, column=form.column._replace(kind="missed"))])

    robot = CODE.pool[STOP].target
    assert mode.faults == STOP
    assert mode.item == f"{robot} motion"
    assert mode.failure_mode == "StopRobot from tick 100 to 150"
    assert mode.local_effect.startswith("At tick 99, the commanded speed of ")
    assert f" ({robot}) was 0 instead of " in mode.local_effect
    assert mode.end_effect == f"{goal.name} ({goal.id})"
    assert mode.detected == "The CI does not detect it in 2 of 3 breaking variants"
    assert mode.severity == "missed"
    assert (mode.number, mode.occurrence) == (1, None)
    outcome = ReferenceEngine(CODE, 1).evaluate(form.witness)
    counts = outcome.believed[0], outcome.true[0], outcome.missed[0]
    assert mode.ticks == max(counts)
    assert mode.measures == "believed {}, true {}, missed {}".format(*counts)


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

    assert [mode.severity for mode in unknown] == ["missed", *["violated"] * 3]
    ticks = [mode.ticks for mode in unknown[1:]]
    assert ticks == sorted(ticks, reverse=True)
    assert [mode.occurrence for mode in known] == pytest.approx([0.5, 0.1, 0.1, 0.05])
    assert known[1].severity == "missed"
    assert [mode.occurrence for mode in partly] == [0.5, None, None, None]
    assert all(
        "; " in each for each in (known[3].item, known[3].failure_mode, known[3].local_effect)
    )
