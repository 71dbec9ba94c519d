"""Goal tasks on states laid out by hand: violations, reactions, purpose and tolerance."""

import math
import sys
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

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
from mrsfi_runtime.kernel.commands import move, set_speed, steer, switch_sensor
from mrsfi_runtime.kernel.effects import issue
from mrsfi_runtime.kernel.flight import count, initial_state, lasting, no_verdicts
from mrsfi_runtime.kernel.forecast import energy_reserve
from mrsfi_runtime.kernel.goal_tasks import table as goal_tasks
from mrsfi_runtime.kernel.goal_tasks.common import NEVER, NO_MARGIN, patience
from mrsfi_runtime.kernel.goal_tasks.table import is_missed
from mrsfi_runtime.kernel.injections import Plan
from mrsfi_runtime.kernel.state import GraceState, excess
from mrsfi_runtime.model.mission import Area, Coordinates, Obstacle, Outcome
from tests.support.world import MEMBERS, mission, robot, stand, state

HERE = Area("here", Coordinates(0.0, 0.0), 50.0)
ROCK = Obstacle("rock", Area("rock_area", Coordinates(100.0, 0.0), 10.0))
ROUNDED = (1.0 - 1e-12, 1.0, 1.0 + 1e-12)
"""Factors that rounding may well amount to."""
NORTHWARD = (Coordinates(0.0, 0.0), Coordinates(0.0, 100.0))
NUMBERS = st.floats(-1e6, 1e6)


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
        stand(view)
        found[value] = sys.modules[type(task).__module__].violated(view, 0)

    assert {value for value, is_violated in found.items() if is_violated} == {*violated}


@pytest.mark.parametrize(
    ("required", "expected"), [(0, ".!!!"), (3, ".!!!"), (2, "..!!"), (1, "...!")]
)
def test_a_goal_is_violated_if_fewer_members_than_it_requires_keep_its_rule(required, expected):
    robots = tuple(robot(name, 0.0, 100.0 * n) for n, name in enumerate("abc"))
    small = mission(StayWithinMissionArea(), robots=robots)
    goals = (replace(small.goals[0], required_members=required),)
    view = initial_state(replace(small, goals=goals), seed=1)

    violated = ""
    for n_outside in range(4):
        for each in view.robots[:n_outside]:
            each.x = 2000.0
        violated += "!" if goal_tasks.stay_within_mission_area.violated(view, 0) else "."

    assert violated == expected


@given(st.lists(st.floats(0.0), min_size=1, max_size=6), st.data())
def test_the_kth_best_value_is_the_kth_largest(energies, drawn):
    required = drawn.draw(st.integers(1, len(energies)))
    robots = tuple(robot(f"r{n}", 0.0, 0.0) for n in range(len(energies)))
    view = replace(state(SufficientEnergy(), robots=robots), required=(required,))
    for each, energy in zip(view.robots, energies, strict=True):
        each.energy = energy

    found = goal_tasks.sufficient_energy.decisive(view, 0)

    assert found == sorted(energies, reverse=True)[required - 1]


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
    for total, x in ((1, 0.0), (3, 0.0), (4, 1.0), (9, 60.0), (10, 2.0), (10, 3.0)):
        view.sensors[1].count, view.robots[0].x = total, x
        goal_tasks.gather_samples.progress(view, 0)

    assert view.goals[0].count == 1 + 1 + 1


LOOP = (HERE, Area("b", Coordinates(60.0, 0.0), 5.0))
PATH = (Coordinates(0.0, 0.0), Coordinates(100.0, 0.0))


@pytest.mark.parametrize(
    ("task", "places", "expected"),
    [
        (Patrol(HERE, period=3), [(0, 0), (60, 0), (60, 0), (60, 0), (10, 0)], "...!."),
        (Patrol(None, 2, LOOP), [(60, 0), (0, 0), (1, 0), (60, 0), (60, 0), (0, 0)], "......"),
        (Patrol(None, 2, LOOP), [(0, 0), (0, 0), (0, 0), (60, 0), (60, 0), (60, 0)], "..!..!"),
        (Visit(Coordinates(60.0, 0.0), 1.0, 2), [(0, 0), (0, 0), (0, 0), (59, 0), (0, 0)], "..!.."),
        (Track(PATH, 5.0), [(-50, 50), (0, 3), (50, 5), (50, 6), (98, 0), (50, 50)], "...!.."),
        (Stay(HERE), [(90, 0), (10, 0), (90, 0), (10, 0)], "..!."),
    ],
    ids=lambda value: type(value).__name__,
)
def test_what_remembers_is_violated(task, places, expected):
    """A patrol after one period away from its next area, a visit from its deadline until it
    happens, a track off its current segment only, and a stay outside after the first entry.
    """
    view = state(task, robots=(robot("a", 0.0, 0.0),))
    module = getattr(goal_tasks, type(task).__name__.lower())
    violated = ""
    for tick, (x, y) in enumerate(places):
        view.mission.tick, view.robots[0].x, view.robots[0].y = tick, float(x), float(y)
        module.progress(view, 0)
        violated += "!" if module.violated(view, 0) else "."

    assert violated == expected


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
    ci = state(Track(NORTHWARD, 5.0), robots=(robot("a", 0.0, 0.0),))
    ci.members[0].waypoint = 1

    goal_tasks.track.react(ci, 0)

    assert heading(ci, 0) == 90


@pytest.mark.parametrize(("distance", "expected"), [(50.0, 180), (150.0, 0)])
def test_a_follower_closes_or_opens_the_gap(distance, expected):
    ci = state(FixedDistanceBetweenRobots(distance, 2.0))

    goal_tasks.fixed_distance_between_robots.react(ci, 0)

    assert heading(ci, 1) == expected


@pytest.mark.parametrize("violated", [0, 1])
def test_most_tasks_are_missed_from_their_first_violation_on(violated):
    assert is_missed(state(AvoidCollision(MEMBERS)), 0, violated) is bool(violated)


@pytest.mark.parametrize(("energy", "expected"), [(1e-3, False), (0.0, True)])
def test_energy_is_missed_when_a_member_has_none_left_whatever_its_forecast(energy, expected):
    world = state(SufficientEnergy())
    world.robots[1].energy = energy

    assert is_missed(world, 0, 1) is expected


@pytest.mark.parametrize(
    ("count", "tick", "energy", "expected"),
    [
        (0, 0, 1.0, False),
        (0, 97, 1.0, False),  # two ticks are left, of two samples each
        (0, 98, 1.0, True),
        (2, 98, 1.0, False),
        (3, 99, 1.0, True),
        (3, 0, 0.0, True),
        (4, 99, 0.0, False),
    ],
)
def test_samples_are_missed_when_all_that_can_still_come_are_too_few(count, tick, energy, expected):
    world = state(GatherSamples(4, "a_depth"), area=HERE, duration=100)
    world.goals[0].count = count
    world.mission.tick = tick
    world.robots[0].energy = energy

    assert is_missed(world, 0, 1) is expected


@pytest.mark.parametrize(
    ("violated", "tick", "is_done", "expected"),
    [(0, 98, 0, False), (0, 99, 0, True), (0, 99, 1, False), (1, 5, 1, True)],
)
@pytest.mark.parametrize(
    ("task", "field", "values"),
    [(Stay(HERE), "since", (-1, 99)), (Track(NORTHWARD, 5.0), "waypoint", (1, 2))],
)
def test_stay_and_track_are_missed_by_leaving_or_by_what_is_not_done_at_the_end(
    task, field, values, violated, tick, is_done, expected
):
    world = state(task, duration=100)
    world.mission.tick = tick
    for member in world.members:
        setattr(member, field, values[is_done])

    assert is_missed(world, 0, violated) is expected


@pytest.mark.parametrize(
    ("believed", "expected"),
    [
        ((0, 0, 0, 1, 0), (3, 1)),
        ((0, 0, 1, 0, 0), (3, 0)),
        ((1, 1, 0, 0, 0), (3, 3)),  # a false alarm, and nothing when it happens
        ((0, 0, 0, 0, 1), (3, 2)),
    ],
)
def test_what_is_believed_counts_from_the_first_true_violation(believed, expected):
    world = state(AvoidCollision(MEMBERS), duration=5)
    verdicts = no_verdicts(1)
    for tick, judged in enumerate(zip((0, 0, 1, 0, 1), believed, strict=True)):
        world.mission.tick = tick
        verdicts.is_true[0], verdicts.is_believed[0] = judged
        count(verdicts, world)

    assert (verdicts.broken[0], verdicts.undetected[0]) == expected


@pytest.mark.parametrize(("believed", "expected"), [(0, (1, 1)), (1, (1, 0))])
def test_what_is_missed_without_a_violation_is_broken_from_then_on(believed, expected):
    world = state(Stay(HERE), duration=3)
    verdicts = no_verdicts(1)
    for tick in range(3):
        world.mission.tick = tick
        verdicts.is_believed[0] = believed
        count(verdicts, world)

    assert (verdicts.broken[0], verdicts.undetected[0]) == expected


def test_what_was_missed_once_stays_missed():
    world = state(AvoidCollision(MEMBERS), duration=10)
    verdicts = no_verdicts(1)
    for tick, violated in enumerate((0, 0, 0, 1, 0, 1, 0, 0, 0, 0)):
        world.mission.tick = tick
        verdicts.is_true[0] = violated
        count(verdicts, world)

    outcome = Outcome((0,), (2,), (0,), (2,), tuple(verdicts.missed), (0,), (), (), "")
    assert (verdicts.true, outcome.missed, outcome.missed_since(10)) == ([2], (7,), (3,))
    assert Outcome((0,), (0,), (0,), (0,), (0,), (0,), (), (), "").missed_since(10) == (None,)


@pytest.mark.parametrize(
    ("value", "expected"),
    [(100.0 + 5e-8, 0.0), (100.0 - 5e-8, 0.0), (101.0, 1.0), (99.0, -1.0), (100.0 + 2e-7, 2e-7)],
)
def test_what_differs_by_less_than_a_billionth_is_equal(value, expected):
    assert excess(value, 100.0) == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize("share", ROUNDED)
def test_energy_that_covers_the_need_but_for_rounding_suffices(share):
    view = state(SufficientEnergy(), duration=11)
    for each in view.robots:
        each.energy = share * 10 * (4.0 * 5.0 + 2 * 3.0 * 2)

    assert not goal_tasks.sufficient_energy.violated(view, 0)

    view.robots[1].energy -= 0.5
    assert goal_tasks.sufficient_energy.violated(view, 0)


@pytest.mark.parametrize("share", ROUNDED)
def test_the_edge_of_an_area_is_inside(share):
    patrol = state(Patrol(HERE, 1))
    gather = state(GatherSamples(5, "a_depth"), area=HERE)
    for view in (patrol, gather):
        for each in view.robots:
            each.x = share * 50.0
    patrol.mission.tick = 1

    goal_tasks.patrol.progress(patrol, 0)

    assert not goal_tasks.patrol.violated(patrol, 0)
    assert not goal_tasks.gather_samples.violated(gather, 0)


@pytest.mark.parametrize("share", ROUNDED)
def test_energy_that_is_used_up_but_for_rounding_is_used_up(share):
    world = state(SufficientEnergy())
    world.robots[0].energy = share * (4.0 * 5.0 + 2 * 3.0 * 2)

    move(world, [0] * 4, 0)

    assert world.robots[0].energy == 0.0


def test_a_direction_that_is_nothing_but_rounding_is_ignored():
    ci = state()
    before = ci.commands[0].heading_x

    steer(ci, 0, math.ulp(1.0), 0.0)

    assert ci.commands[0].heading_x == before


@given(NUMBERS, NUMBERS, st.floats(0.0, 1e3))
def test_a_margin_is_looked_at_before_it_can_be_the_least(left, least, speed):
    wait = patience(left, least, speed)

    assert wait >= 1
    assert wait == 1 or left - (wait - 1) * speed >= least


@pytest.mark.parametrize(
    ("left", "speed", "expected"), [(3.0, 0.0, NEVER), (NO_MARGIN, 2.0, NEVER), (7.0, 2.0, 3)]
)
def test_what_cannot_come_nearer_is_not_looked_at(left, speed, expected):
    assert patience(left, 1.0, speed) == expected


@given(st.lists(st.floats(-9.0, 9.0), min_size=1), st.data())
def test_the_margin_of_a_grace_is_the_greatest_of_its_ticks(margins, data):
    grace = data.draw(st.integers(1, len(margins)))
    world = state(StayWithinMissionArea())
    world.grace, world.latest = [GraceState(grace, 0)], [NO_MARGIN] * (grace + 2)

    found = []
    for world.mission.tick, left in enumerate(margins):
        found.append(lasting(world, world.grace[0], left))

    first = [NO_MARGIN] * min(grace, len(margins))
    assert found == first + [max(margins[t - grace : t + 1]) for t in range(grace, len(margins))]
