"""What is left to limits is negative exactly where the reference check finds a goal violated."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mrsfi_runtime.analysis.margins import margins
from mrsfi_runtime.api import (
    AvoidCollision,
    FixedDistanceBetweenRobots,
    GatherSamples,
    Patrol,
    Stay,
    StayWithinMissionArea,
    SufficientEnergy,
    Track,
    Visit,
)
from mrsfi_runtime.kernel.goal_tasks import table
from mrsfi_runtime.model.mission import Area, Coordinates, Obstacle
from tests.support.world import MEMBERS, state
from tests.tiers import law, slow

HERE = Area("here", Coordinates(0.0, 0.0), 50.0)
ROCK = Obstacle("rock", Area("rock_area", Coordinates(20.0, 0.0), 10.0))
CASES = {
    "avoid_collision": AvoidCollision(MEMBERS, ("rock",)),
    "stay_within_mission_area": StayWithinMissionArea(),
    "sufficient_energy": SufficientEnergy(),
    "gather_samples": GatherSamples(40, "a_depth"),
    "patrol": Patrol(HERE, 20),
    "visit": Visit(Coordinates(10.0, 0.0), 2.0, 60),
    "track": Track((Coordinates(0.0, 0.0), Coordinates(0.0, 60.0)), 4.0),
    "stay": Stay(HERE),
    "fixed_distance_between_robots": FixedDistanceBetweenRobots(30.0, 8.0),
}
NEAR = st.sampled_from([0.0, 8.0, 18.0, 22.0, 38.0, 50.0, 62.0]) | st.floats(-70.0, 70.0)
TICKS = st.integers(0, 99)
FAR = st.sampled_from([-1000.0, 990.0, 1000.0, 1001.0])


@slow
@given(st.data())
@pytest.mark.parametrize("task", CASES)
@law(200)
def test_a_margin_is_negative_exactly_where_the_goal_is_violated(task, data):
    module = getattr(table, task)
    world = state(CASES[task], area=HERE, obstacles=(ROCK,), duration=100)
    for tick in data.draw(st.lists(TICKS, min_size=1, max_size=3, unique=True).map(sorted)):
        world.mission.tick = tick
        for robot in world.robots:
            robot.x, robot.y = data.draw(NEAR | FAR), data.draw(NEAR)
            robot.energy = data.draw(st.sampled_from([0.0, 1.0, 1e4]) | st.floats(0.0, 5e3))
            robot.speed = data.draw(st.sampled_from([0.0, 4.0]))
        for sensor in world.sensors:
            sensor.active = data.draw(st.integers(0, 1))
            sensor.count += data.draw(st.integers(0, 30))
            sensor.rate = data.draw(st.sampled_from([0.0, 1.0, 2.0]))
        if hasattr(module, "progress"):
            module.progress(world, 0)

        left = margins(world, 0)

        assert left is not None
        assert (min(left.values()) < 0.0) == module.violated(world, 0)
        assert not any(map(math.isnan, left.values()))


def test_of_a_task_of_a_teams_own_nobody_knows_what_is_left():
    world = state(table.OwnTask("Escort"))

    assert margins(world, 0) is None
