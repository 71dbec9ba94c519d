"""When each of the nine tasks is violated, on states laid out by hand."""

import sys

import pytest

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
from mrsfi_runtime.kernel.goal_tasks import table as goal_tasks
from mrsfi_runtime.model.mission import Area, Coordinates, Obstacle
from tests.support.world import MEMBERS, robot, state

HERE = Area("here", Coordinates(0.0, 0.0), 50.0)
ROCK = Obstacle("rock", Area("rock_area", Coordinates(100.0, 0.0), 10.0))
ROUNDED = (1.0 - 1e-12, 1.0, 1.0 + 1e-12)
"""Factors that rounding may well amount to."""


@pytest.mark.parametrize(
    ("task", "robot", "kept", "violated"),
    [
        (AvoidCollision(MEMBERS), "bx", [2.0], [1.999, -1.5]),
        (AvoidCollision(MEMBERS, ("rock",)), "by", [11.0], [10.9]),
        (AvoidCollision(MEMBERS), "by", [10.9], []),  # the rock is not listed
        (StayWithinMissionArea(), "ax", [1000.0], [1000.5]),
        (FixedDistanceBetweenRobots(100.0, 2.0), "bx", [98.0, 102.0], [97.0, 103.0]),
    ],
)
def test_a_task_is_violated_beyond_its_edge_whatever_is_rounded(task, robot, kept, violated):
    view = state(task, obstacles=(ROCK,))
    moved, axis = view.robots["ab".index(robot[0])], robot[1]

    found = {}
    for value in (*(share * edge for edge in kept for share in ROUNDED), *violated):
        setattr(moved, axis, value)
        found[value] = sys.modules[type(task).__module__].violated(view, 0)

    assert {value for value, is_violated in found.items() if is_violated} == {*violated}


def test_energy_suffices_when_it_covers_the_forecast_exactly():
    view = state(SufficientEnergy(), duration=11)
    for each in view.robots:
        each.speed = 4.0
        each.energy = 10 * (4.0 * 5.0 + 2 * 3.0 * 2)

    assert not goal_tasks.sufficient_energy.violated(view, 0)

    view.robots[1].energy -= 0.5
    assert goal_tasks.sufficient_energy.violated(view, 0)


def test_an_exhausted_robot_violates_its_energy_goal_even_at_the_last_tick():
    view = state(SufficientEnergy(), duration=1)
    view.robots[1].energy = 0.0

    assert goal_tasks.sufficient_energy.violated(view, 0)


def _gathering(target=5, duration=11):
    view = state(GatherSamples(target, "a_depth"), area=HERE, duration=duration)
    view.sensors[1].count = 0
    return view


def test_gathering_is_violated_by_a_dead_sensor_a_robot_outside_or_a_short_forecast():
    assert not goal_tasks.gather_samples.violated(_gathering(), 0)

    dead = _gathering()
    dead.sensors[1].active = 0
    assert goal_tasks.gather_samples.violated(dead, 0)

    outside = _gathering()
    outside.robots[0].x = 51.0
    assert goal_tasks.gather_samples.violated(outside, 0)

    slow = _gathering()
    slow.sensors[1].rate = 0.9
    assert goal_tasks.gather_samples.violated(slow, 0)


def test_gathering_is_never_violated_once_the_target_is_reached():
    view = _gathering(target=5)
    view.goals[0].count = 5
    view.sensors[1].active = 0

    assert not goal_tasks.gather_samples.violated(view, 0)


def test_samples_count_inside_the_area_and_only_after_moving():
    view = _gathering()
    for count, x in ((1, 0.0), (3, 0.0), (4, 1.0), (9, 60.0), (10, 2.0), (10, 3.0)):
        view.sensors[1].count, view.robots[0].x = count, x
        goal_tasks.gather_samples.progress(view, 0)

    assert view.goals[0].count == 1 + 1 + 1


PATH = (Coordinates(0.0, 0.0), Coordinates(100.0, 0.0))


@pytest.mark.parametrize(
    ("task", "places", "expected"),
    [
        (Patrol(HERE, period=3), [(0, 0), (60, 0), (60, 0), (60, 0), (10, 0)], "...!."),
        (Visit(Coordinates(60.0, 0.0), 1.0, 2), [(0, 0), (0, 0), (0, 0), (59, 0), (0, 0)], "..!.."),
        (Track(PATH, 5.0), [(-50, 50), (0, 3), (50, 5), (50, 6), (98, 0), (50, 50)], "...!.."),
        (Stay(HERE), [(90, 0), (10, 0), (90, 0), (10, 0)], "..!."),
    ],
    ids=lambda value: type(value).__name__,
)
def test_what_remembers_is_violated(task, places, expected):
    """A patrol after one period away, a visit from its deadline until it happens, a track off its
    current segment only, and a stay outside after the first entry.
    """
    view = state(task, robots=(robot("a", 0.0, 0.0),))
    module = getattr(goal_tasks, type(task).__name__.lower())
    violated = ""
    for tick, (x, y) in enumerate(places):
        view.mission.tick, view.robots[0].x, view.robots[0].y = tick, float(x), float(y)
        module.progress(view, 0)
        violated += "!" if module.violated(view, 0) else "."

    assert violated == expected
