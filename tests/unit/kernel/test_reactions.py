"""What the reference collective intelligence commands, on states laid out by hand."""

import math

import pytest

from mrsfi_runtime.api import (
    AvoidCollision,
    FixedDistanceBetweenRobots,
    GatherSamples,
    StayWithinMissionArea,
    SufficientEnergy,
    Track,
    Visit,
)
from mrsfi_runtime.kernel.commands import set_speed, steer, switch_sensor
from mrsfi_runtime.kernel.effects import issue
from mrsfi_runtime.kernel.forecast import energy_reserve
from mrsfi_runtime.kernel.goal_tasks import table as goal_tasks
from mrsfi_runtime.kernel.injections import Plan
from mrsfi_runtime.model.mission import Area, Coordinates, Obstacle
from tests.support.world import MEMBERS, robot, state

HERE = Area("here", Coordinates(0.0, 0.0), 50.0)


def heading(ci, index):
    command = ci.commands[index]
    return round(math.degrees(math.atan2(command.heading_y, command.heading_x))) % 360


def test_the_first_goal_to_speak_keeps_the_channel():
    ci = state()

    steer(ci, 0, 0.0, 2.0)
    steer(ci, 0, 1.0, 0.0)
    set_speed(ci, 0, 3.0)
    set_speed(ci, 0, 1.0)
    switch_sensor(ci, 1, 0)
    switch_sensor(ci, 1, 1)

    assert heading(ci, 0) == 90
    assert ci.commands[0].speed == 3.0
    assert ci.switches[1].active == 0


@pytest.mark.parametrize(("speed", "expected"), [(-1.0, 0.0), (7.0, 7.0), (99.0, 8.0)])
def test_commanded_speeds_stay_within_twice_nominal_if_a_region_writes_them_too(speed, expected):
    ci, orders = state(), state()

    set_speed(ci, 0, speed)

    assert ci.commands[0].speed == expected
    ci.commands[0].speed = speed
    issue(ci, orders, Plan([], [], [], [], [], [], [], [], []), 1)
    assert (orders.commands[0].speed, ci.commands[0].sent_speed) == (expected, expected)


def test_a_robot_turns_away_from_an_obstacle_ahead():
    rock = Obstacle("rock", Area("rock_area", Coordinates(40.0, 0.0), 10.0))
    ci = state(AvoidCollision(("a",), ("rock",)), obstacles=(rock,))
    ci.commands[0].heading_x, ci.commands[0].heading_y = 1.0, 0.0

    goal_tasks.avoid_collision.react(ci, 0)

    assert 90 < heading(ci, 0) < 270


def test_a_robot_with_a_clear_way_keeps_its_heading():
    ci = state(AvoidCollision(MEMBERS))
    ci.commands[0].heading_x, ci.commands[0].heading_y = 0.0, 1.0
    ci.commands[1].heading_x, ci.commands[1].heading_y = 0.0, 1.0

    goal_tasks.avoid_collision.react(ci, 0)

    assert (heading(ci, 0), heading(ci, 1)) == (90, 90)


@pytest.mark.parametrize("sides", [4, 6])
def test_of_headings_that_are_alike_but_for_rounding_the_first_wins(sides):
    places = [2 * math.pi * k / sides for k in range(sides)]
    rocks = tuple(
        Obstacle(f"o{k}", Area(f"a{k}", Coordinates(8 * math.cos(at), 8 * math.sin(at)), 3.0))
        for k, at in enumerate(places)
    )
    listed = tuple(rock.id for rock in rocks)
    ci = state(AvoidCollision(("a",), listed), obstacles=rocks, robots=(robot("a", 0.0, 0.0),))
    ci.commands[0].heading_x, ci.commands[0].heading_y = 1.0, 0.0

    goal_tasks.avoid_collision.react(ci, 0)

    assert heading(ci, 0) == 180 / sides


def test_robots_on_collision_course_part():
    ci = state(AvoidCollision(MEMBERS))
    ci.robots[1].x = 40.0
    ci.commands[0].heading_x, ci.commands[0].heading_y = 1.0, 0.0
    ci.commands[1].heading_x, ci.commands[1].heading_y = -1.0, 0.0

    goal_tasks.avoid_collision.react(ci, 0)

    assert heading(ci, 0) != 0


def test_a_robot_about_to_leave_the_mission_area_turns_to_its_centre():
    ci = state(StayWithinMissionArea())
    ci.robots[0].x = 995.0
    ci.commands[0].heading_x, ci.commands[0].heading_y = 1.0, 0.0

    goal_tasks.stay_within_mission_area.react(ci, 0)

    assert heading(ci, 0) == 180


@pytest.mark.parametrize(
    ("believed", "expected"), [(4.0, 4.0), (0.0, 8.0), (50.0, 0.0), (3.0, 5.0)]
)
def test_speed_is_regulated_over_the_reported_speed(believed, expected):
    ci = state(SufficientEnergy())
    ci.robots[0].speed = believed

    goal_tasks.sufficient_energy.react(ci, 0)

    assert ci.commands[0].speed == expected


def test_with_too_little_energy_a_robot_wants_only_what_it_affords():
    ci = state(SufficientEnergy(), duration=11)
    ci.robots[0].speed = 4.0
    ci.robots[0].energy = 10 * (2 * 3.0 * 2 + 1.5 * 5.0)

    goal_tasks.sufficient_energy.react(ci, 0)

    afforded = 0.999 * ci.robots[0].energy / 10 - 2 * 3.0 * 2
    assert ci.commands[0].speed == pytest.approx(afforded / 5.0, rel=1e-12)


def test_the_least_energy_that_a_robot_keeps_outlasts_rounding():
    ci = state(SufficientEnergy(), duration=101)
    ci.robots[0].energy = 100 * (3.0 * 5.0 + 2 * 3.0 * 2)

    goal_tasks.sufficient_energy.react(ci, 0)
    ci.robots[0].speed = ci.commands[0].speed

    assert energy_reserve(ci, 0) == pytest.approx(0.001 * ci.robots[0].energy)


def test_speed_is_regulated_from_what_the_robot_was_told():
    ci = state(SufficientEnergy())
    ci.robots[0].speed = ci.commands[0].sent_speed = 0.0

    for _ in range(3):
        ci.commands[0].speed_claimed = 0
        goal_tasks.sufficient_energy.react(ci, 0)

    assert ci.commands[0].speed == 4.0


def test_gathering_heads_for_the_area_and_switches_the_sensor_by_need():
    ci = state(GatherSamples(5, "a_depth"), area=HERE)
    ci.robots[0].y = -200.0
    ci.switches[1].active = 0

    goal_tasks.gather_samples.react(ci, 0)

    assert heading(ci, 0) == 90
    assert ci.switches[1].active == 1

    ci.goals[0].count = 5
    ci.switches[1].claimed = 0
    goal_tasks.gather_samples.react(ci, 0)
    assert ci.switches[1].active == 0


def test_a_roaming_robot_stays_inside_its_area():
    ci = state(GatherSamples(5, "a_depth"), area=HERE)
    me, command = ci.robots[0], ci.commands[0]
    for tick in range(500):
        ci.mission.tick = tick
        command.heading_claimed = 0
        goal_tasks.gather_samples.react(ci, 0)
        me.x += command.heading_x * command.speed
        me.y += command.heading_y * command.speed
        assert math.hypot(me.x, me.y) <= 50.0, tick


def test_a_visit_ends_exactly_at_the_point():
    ci = state(Visit(Coordinates(3.0, 0.0), 0.5, 10), robots=(robot("a", 0.0, 0.0),))

    goal_tasks.visit.react(ci, 0)

    assert (heading(ci, 0), ci.commands[0].speed) == (0, 3.0)


def test_tracking_heads_for_the_next_waypoint():
    path = (Coordinates(0.0, 0.0), Coordinates(0.0, 100.0))
    ci = state(Track(path, 5.0), robots=(robot("a", 0.0, 0.0),))
    ci.members[0].waypoint = 1

    goal_tasks.track.react(ci, 0)

    assert heading(ci, 0) == 90


@pytest.mark.parametrize(("distance", "expected"), [(50.0, 180), (150.0, 0)])
def test_a_follower_closes_or_opens_the_gap(distance, expected):
    ci = state(FixedDistanceBetweenRobots(distance, 2.0))

    goal_tasks.fixed_distance_between_robots.react(ci, 0)

    assert heading(ci, 1) == expected
