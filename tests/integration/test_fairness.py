"""The world is fair: no finding is made by rounding, an unknown beginning, or impossible speeds."""

from dataclasses import replace

import pytest

from mrsfi_runtime.engine.flights import ReferenceEngine
from mrsfi_runtime.model.faults import Fault, FaultPool, TimedFault
from tests.support.world import code_of, paper_code
from tests.tiers import seeds

ODD = {"turn_rate": 45.0, "position_noise": 1.0}
MISSIONS = ("uuv_sampling", "tight_margins", "tight_energy", "depot")


def speeds(code, pool, specification):
    """Fly, and return the true speeds of the first robot of a goal, tick by tick."""
    found = []
    with ReferenceEngine(code, 1) as engine:
        outcome = engine.evaluate(
            specification,
            pool=pool,
            observer=lambda world, *_: found.append([robot.speed for robot in world.robots]),
        )
    return outcome, found


@pytest.mark.parametrize("start", [0, 1])
@pytest.mark.parametrize(
    ("kind", "values"), [("BlockMessage", (900.0,)), ("DelayMessage", (30.0,))]
)
def test_a_speed_never_heard_of_is_believed_to_be_nominal(kind, values, start):
    code = paper_code()
    types = {fault.type: fault.kind for fault in code.pool}
    pool = FaultPool("held", (Fault("held", types[kind], "m7", values),))

    outcome, found = speeds(code, pool, (TimedFault("held", start, 900, values),))

    nominal = code.mission.robots[1].speed
    assert {each[1] for each in found} == {nominal}
    assert outcome.true[2] == 0


@pytest.mark.parametrize("seed", seeds(range(20), 3, 6))
@pytest.mark.parametrize("mission", MISSIONS)
def test_without_faults_nothing_is_violated_or_missed_and_every_sample_taken(mission, seed):
    mission_code = code_of(mission)
    goals = mission_code.mission.goals

    outcome = ReferenceEngine(mission_code, seed).evaluate(())

    assert (outcome.believed, outcome.true, outcome.missed) == ((0,) * len(goals),) * 3
    for goal, taken in zip(goals, outcome.samples, strict=True):
        assert taken >= getattr(goal.task, "target_sample_number", 0)


@pytest.mark.parametrize("seed", seeds(range(20), 2, 6))
@pytest.mark.parametrize("mission", ["uuv_sampling", "tight_energy", "undersea"])
@pytest.mark.parametrize("given", [["turn_rate"], ["position_noise"], [*ODD]])
def test_robots_that_turn_slowly_or_report_inexactly_violate_nothing_either(mission, seed, given):
    code = code_of(mission)
    odd = {name: ODD[name] for name in given}
    robots = tuple(replace(robot, **odd) for robot in code.mission.robots)

    outcome = ReferenceEngine(
        replace(code, mission=replace(code.mission, robots=robots)), seed
    ).evaluate(())

    n_goals = len(code.mission.goals)
    assert (outcome.believed, outcome.true, outcome.missed) == ((0,) * n_goals,) * 3
