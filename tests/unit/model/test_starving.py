"""Which goals starve, as others keep their robots elsewhere."""

from dataclasses import replace

import pytest

from mrsfi_runtime.kernel.goal_tasks.avoid_collision import AvoidCollision
from mrsfi_runtime.kernel.goal_tasks.gather_samples import GatherSamples
from mrsfi_runtime.kernel.goal_tasks.patrol import Patrol
from mrsfi_runtime.kernel.goal_tasks.stay import Stay
from mrsfi_runtime.kernel.goal_tasks.track import Track
from mrsfi_runtime.kernel.goal_tasks.visit import Visit
from mrsfi_runtime.model.mission import Area, Coordinates, starvation
from tests.support.world import mission

HERE = Area("here", Coordinates(0.0, 0.0), 50.0)
FAR = Area("far", Coordinates(200.0, 0.0), 50.0)
NEXT = Area("next", Coordinates(100.0, 0.0), 50.0)
GATHER = GatherSamples(10, "a_depth")
BY_GATHERING = ("GatherSamples g1", "here", ["a"])


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
        ((Patrol(HERE, 9), at(54.0)), [("Patrol g1", "here", ["a", "b"])]),
        ((Stay(HERE), Patrol(FAR, 9)), [("Stay g1", "here", ["a", "b"])]),
        ((Stay(HERE), Patrol(NEXT, 9)), []),
        ((Patrol(FAR, 9), GATHER), [("Patrol g1", "far", ["a"])]),
        ((GATHER, Track((Coordinates(0.0), Coordinates(54.0)), 3.0)), [BY_GATHERING]),
        ((GATHER, Track((Coordinates(0.0), Coordinates(53.0)), 3.0)), []),
        ((GATHER, Stay(FAR), at(120.0)), [BY_GATHERING, ("Stay g2", "far", ["a", "b"])]),
        ((GATHER, AvoidCollision(("a", "b"), ())), []),
    ],
)  # fmt: skip
def test_a_goal_starves_where_one_before_it_keeps_its_robots_elsewhere(tasks, expected):
    assert told(*tasks) == said(*expected)


def test_a_goal_of_other_robots_holds_nothing():
    found = mission(GATHER, at(54.0), area=HERE)
    other = replace(found.goals[1], members=("b",))

    assert starvation(replace(found, goals=(found.goals[0], other)), other) == ""
