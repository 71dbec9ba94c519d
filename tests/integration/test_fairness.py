"""The world is fair: no finding is made by rounding, an unknown beginning, or impossible speeds."""

import pytest

from mrsfi_runtime.cosimulation.lockstep import move
from mrsfi_runtime.engine.flights import ReferenceEngine
from mrsfi_runtime.kernel.state import excess
from mrsfi_runtime.model.faults import Fault, FaultPool, TimedFault
from tests.support.world import code_of, paper_code, specifications
from tests.tiers import night, seeds, slow

MISSIONS = ("uuv_sampling", "tight_margins", "tight_energy")


def move_and_spend_apart(world, tick):
    """Move as ``move`` does, but take off what sensors cost before what the way costs."""
    before = [robot.energy for robot in world.robots]
    move(world, tick)
    for robot, energy in zip(world.robots, before, strict=True):
        if energy > 0.0:
            sensors = world.sensors[robot.first_sensor : robot.first_sensor + robot.n_sensors]
            costs = sum(each.active * each.nominal_rate * each.nominal_cost for each in sensors)
            way = robot.speed * robot.energy_per_distance
            robot.energy = 0.0 if excess(energy, costs + way) <= 0.0 else energy - costs - way


def counts(outcome):
    return outcome.believed, outcome.true, outcome.missed, outcome.samples


@night
def test_no_outcome_depends_on_the_order_of_two_subtractions(monkeypatch):
    code = code_of("tight_energy")
    flown = specifications(code, 60)
    with ReferenceEngine(code, 1) as engine:
        expected = [engine.evaluate(each) for each in flown]
        step = type(engine._simulation).step
        assert step.__globals__["move"] is move

        monkeypatch.setitem(step.__globals__, "move", move_and_spend_apart)
        found = [engine.evaluate(each) for each in flown]

    digests = [(one.digest, other.digest) for one, other in zip(found, expected, strict=True)]
    assert sum(one != other for one, other in digests) > 10  # last bits do differ
    assert [counts(each) for each in found] == [counts(each) for each in expected]


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


@slow
@pytest.mark.parametrize("mission", MISSIONS)
def test_no_robot_flies_faster_than_it_can(mission):
    code = code_of(mission)
    most = [robot.fastest for robot in code.mission.robots]

    fastest = 0.0
    for each in specifications(code, 8):
        _, found = speeds(code, None, each)
        for tick in found:
            for speed, limit in zip(tick, most, strict=True):
                assert 0.0 <= speed <= limit
                fastest = max(fastest, speed / limit)

    assert fastest == 1.0  # the limit is met


@pytest.mark.parametrize("seed", seeds(range(20), 3, 6))
@pytest.mark.parametrize("mission", MISSIONS)
def test_without_faults_nothing_is_violated_or_missed_and_every_sample_taken(mission, seed):
    mission_code = code_of(mission)
    goals = mission_code.mission.goals

    outcome = ReferenceEngine(mission_code, seed).evaluate(())

    assert (outcome.believed, outcome.true, outcome.missed) == ((0,) * len(goals),) * 3
    for goal, taken in zip(goals, outcome.samples, strict=True):
        assert taken >= getattr(goal.task, "target_sample_number", 0)
