"""When each of the nine tasks is violated, on states laid out by hand."""

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


@pytest.mark.parametrize(("x", "expected"), [(1.999, True), (2.0, False), (-1.5, True)])
def test_robots_collide_when_their_discs_overlap(x, expected):
    view = state(AvoidCollision(MEMBERS))
    view.robots[1].x = x

    assert goal_tasks.avoid_collision.violated(view, 0) is expected


@pytest.mark.parametrize(("y", "expected"), [(10.9, True), (11.0, False)])
def test_a_robot_collides_with_an_obstacle_whose_disc_it_touches(y, expected):
    rock = Obstacle("rock", Area("rock_area", Coordinates(100.0, 0.0), 10.0))
    view = state(AvoidCollision(MEMBERS, ("rock",)), obstacles=(rock,))
    view.robots[1].y = y

    assert goal_tasks.avoid_collision.violated(view, 0) is expected


def test_obstacles_that_are_not_listed_do_not_count():
    rock = Obstacle("rock", Area("rock_area", Coordinates(100.0, 0.0), 10.0))
    view = state(AvoidCollision(MEMBERS), obstacles=(rock,))

    assert not goal_tasks.avoid_collision.violated(view, 0)


@pytest.mark.parametrize(("x", "expected"), [(1000.0, False), (1000.5, True)])
def test_leaving_the_mission_area_is_a_violation(x, expected):
    view = state(StayWithinMissionArea())
    view.robots[0].x = x

    assert goal_tasks.stay_within_mission_area.violated(view, 0) is expected


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


@pytest.mark.parametrize(("x", "expected"), [(97.0, True), (98.0, False), (103.0, True)])
def test_a_pair_must_keep_its_distance_within_tolerance(x, expected):
    view = state(FixedDistanceBetweenRobots(100.0, 2.0))
    view.robots[1].x = x

    assert goal_tasks.fixed_distance_between_robots.violated(view, 0) is expected
