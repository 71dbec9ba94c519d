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


def test_a_patrol_is_violated_after_one_period_away():
    view = state(Patrol(HERE, period=3), robots=(robot("a", 0.0, 0.0),))
    violated = []
    for tick, x in enumerate((0.0, 60.0, 60.0, 60.0, 10.0)):
        view.mission.tick, view.robots[0].x = tick, x
        goal_tasks.patrol.progress(view, 0)
        violated.append(goal_tasks.patrol.violated(view, 0))

    assert violated == [False, False, False, True, False]


def test_a_visit_is_violated_from_its_deadline_until_it_happens():
    view = state(Visit(Coordinates(60.0, 0.0), 1.0, 2), robots=(robot("a", 0.0, 0.0),))
    violated = []
    for tick, x in enumerate((0.0, 0.0, 0.0, 59.0, 0.0)):
        view.mission.tick, view.robots[0].x = tick, x
        goal_tasks.visit.progress(view, 0)
        violated.append(goal_tasks.visit.violated(view, 0))

    assert violated == [False, False, True, False, False]


def test_tracking_is_violated_off_the_current_segment_only():
    path = (Coordinates(0.0, 0.0), Coordinates(100.0, 0.0))
    view = state(Track(path, 5.0), robots=(robot("a", 0.0, 0.0),))
    violated = []
    for x, y in ((-50.0, 50.0), (0.0, 3.0), (50.0, 5.0), (50.0, 6.0), (98.0, 0.0), (50.0, 50.0)):
        view.robots[0].x, view.robots[0].y = x, y
        goal_tasks.track.progress(view, 0)
        violated.append(goal_tasks.track.violated(view, 0))

    assert violated == [False, False, False, True, False, False]


def test_staying_is_violated_outside_after_the_first_entry():
    view = state(Stay(HERE), robots=(robot("a", 0.0, 0.0),))
    violated = []
    for tick, x in enumerate((90.0, 10.0, 90.0, 10.0)):
        view.mission.tick, view.robots[0].x = tick, x
        goal_tasks.stay.progress(view, 0)
        violated.append(goal_tasks.stay.violated(view, 0))

    assert violated == [False, False, True, False]


@pytest.mark.parametrize(("x", "expected"), [(97.0, True), (98.0, False), (103.0, True)])
def test_a_pair_must_keep_its_distance_within_tolerance(x, expected):
    view = state(FixedDistanceBetweenRobots(100.0, 2.0))
    view.robots[1].x = x

    assert goal_tasks.fixed_distance_between_robots.violated(view, 0) is expected
