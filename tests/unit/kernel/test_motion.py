"""A tick of the simulated world: motion, turning, neighbours, samples and random draws."""

import math
from collections import Counter
from dataclasses import replace

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from mrsfi_runtime.api import AvoidCollision
from mrsfi_runtime.engine.compiled.layout import sample_table
from mrsfi_runtime.kernel import guidance, neighbours
from mrsfi_runtime.kernel.commands import move, reports_position, turned
from mrsfi_runtime.kernel.effects import deliver, issue, send
from mrsfi_runtime.kernel.flight import initial_state, sample_chances, valid_samples
from mrsfi_runtime.kernel.goal_tasks import avoid_collision
from mrsfi_runtime.kernel.injections import plan
from mrsfi_runtime.kernel.randomness import PURPOSE_SAMPLES, choice, draw, seed_key, uniform
from mrsfi_runtime.kernel.state import excess
from mrsfi_runtime.model.faults import FaultPool
from mrsfi_runtime.model.mission import Area, Coordinates, Obstacle, Robot, Sensor
from tests.support.world import mission, robot, stand, state
from tests.tiers import law, slow

VALID = [1, 2, 0, 3]
RATES = st.floats(1e-6, 180.0) | st.sampled_from((1e-9, 90.0, 179.9999999, 180.0))
ANGLES = st.floats(-180.0, 180.0) | st.sampled_from((-180.0, -90.0, 0.0, 90.0, 180.0))
places = st.floats(-150.0, 150.0) | st.sampled_from([0.0, 2.0, 16.0, -1e300, 1e300, 1e6])
points = st.tuples(places, places)
steps = st.lists(st.tuples(st.floats(-9.0, 9.0), st.floats(-9.0, 9.0)), min_size=60, max_size=60)


def test_a_robot_moves_by_its_speed_along_its_heading():
    world = state()
    world.commands[0].heading_x, world.commands[0].heading_y = 0.6, 0.8
    world.commands[0].speed = 5.0

    move(world, VALID, 0)

    assert (world.robots[0].x, world.robots[0].y, world.robots[0].speed) == (3.0, 4.0, 5.0)


@pytest.mark.parametrize(("speed", "expected"), [(-1.0, 0.0), (7.0, 7.0), (99.0, 8.0)])
def test_no_command_makes_a_robot_faster_than_it_is(speed, expected):
    world = state()
    world.commands[0].speed = speed

    move(world, VALID, 0)

    assert world.robots[0].speed == expected


def test_energy_pays_for_distance_and_for_all_samples_of_active_sensors():
    world = state()
    world.switches[1].active = 0

    move(world, VALID, 0)

    assert world.robots[0].energy == 10_000.0 - 4.0 * 5.0 - 2 * 3.0
    assert world.robots[1].energy == 10_000.0 - 4.0 * 5.0 - 2 * 3.0 * 2


def test_an_inactive_sensor_takes_no_samples():
    world = state()
    world.switches[1].active = 0

    for tick in range(50):
        move(world, VALID, tick)

    assert [sensor.count for sensor in world.sensors] == [50, 0, 0, 150]


def test_a_robot_without_energy_stops_with_its_sensors():
    world = state(robots=(robot("a", 0.0, 0.0, energy=30.0),))
    move(world, VALID, 0)
    stopped_at = (world.robots[0].x, world.robots[0].y)
    count = world.sensors[0].count

    move(world, VALID, 1)

    assert world.robots[0].energy == 0.0
    assert (world.robots[0].x, world.robots[0].y, world.robots[0].speed) == (*stopped_at, 0.0)
    assert [sensor.active for sensor in world.sensors] == [0, 0]
    assert world.sensors[0].count == count


def test_position_is_reported_only_while_the_gps_is_active():
    world = state()
    world.switches[0].active = 0

    move(world, VALID, 0)

    assert not reports_position(world, 0)
    assert reports_position(world, 1)


def heading(degrees):
    return math.cos(math.radians(degrees)), math.sin(math.radians(degrees))


def between(one, other):
    """Return the angle from a heading to another, in degrees."""
    aside = one[0] * other[1] - one[1] * other[0]
    return math.degrees(math.atan2(aside, one[0] * other[0] + one[1] * other[1]))


def built(**traits):
    return mission(robots=(replace(robot("a", 3.0, 4.0), **traits),))


def trait(rate):
    return initial_state(built(turn_rate=rate), 1).traits[0]


@law(200)
@given(RATES, ANGLES, ANGLES)
def test_a_turn_is_no_longer_than_the_rate_and_goes_towards_what_is_wanted(rate, first, last):
    was, wanted = heading(first), heading(last)

    now = turned(trait(rate), *was, *wanted)

    apart = abs(between(was, wanted))
    assert math.hypot(*now) == pytest.approx(1.0, abs=1e-15)
    assert abs(between(was, now)) == pytest.approx(min(rate, apart), abs=1e-6)
    assert abs(between(now, wanted)) == pytest.approx(max(apart - rate, 0.0), abs=1e-6)


@law(50)
@given(st.floats(2.0, 180.0), ANGLES, ANGLES)
def test_what_is_wanted_for_long_enough_is_reached_to_the_last_bit(rate, first, last):
    now, wanted = heading(first), heading(last)
    n_ticks = math.ceil(abs(between(now, wanted)) / rate) + 1  # rounding may cost one

    for _ in range(n_ticks):
        now = turned(trait(rate), *now, *wanted)

    assert now == wanted


@pytest.mark.parametrize("wanted", [(-1.0, 0.0), (-1.0, -1e-12), (-1.0, 1e-12)])
def test_what_is_straight_behind_is_turned_to_by_the_left(wanted):
    assert turned(trait(30.0), 1.0, 0.0, *wanted) == pytest.approx(heading(30.0))
    assert turned(trait(30.0), 1.0, 0.0, -1.0, -1e-6) == pytest.approx(heading(-30.0))


@law(50)
@given(ANGLES, ANGLES)
def test_a_robot_without_a_rate_takes_every_heading_as_it_is(first, last):
    assert turned(trait(180.0), *heading(first), *heading(last)) == heading(last)


def test_what_leaves_turns_from_what_left_last_and_the_command_stays():
    ci, orders = (initial_state(built(turn_rate=20.0), 1) for _ in range(2))
    ci.commands[0].heading_x, ci.commands[0].heading_y = 0.0, 1.0
    orders.commands[0].heading_x, orders.commands[0].heading_y = 1.0, 0.0
    none = plan(built(), FaultPool((), ()), ())

    sent = []
    for tick in range(6):
        issue(ci, orders, none, tick)
        sent.append(
            between((1.0, 0.0), (orders.commands[0].heading_x, orders.commands[0].heading_y))
        )

    assert sent == pytest.approx([20.0, 40.0, 60.0, 80.0, 90.0, 90.0])
    assert (ci.commands[0].heading_x, ci.commands[0].heading_y) == (0.0, 1.0)


def test_noise_is_drawn_anew_in_every_tick_within_its_disc_and_never_moves_the_robot():
    world, inbox = (initial_state(built(position_noise=2.0), 1) for _ in range(2))
    reported = []
    for tick in range(400):
        world.mission.tick = tick
        send(world, inbox)
        reported.append((inbox.robots[0].x - 3.0, inbox.robots[0].y - 4.0))

    far = [math.hypot(*place) for place in reported]
    assert (world.robots[0].x, world.robots[0].y, inbox.robots[0].z) == (3.0, 4.0, 1.0)
    assert len({*reported}) == len(reported)
    assert max(far) <= 2.0 + 1e-12
    assert 0.45 < sum(each < math.sqrt(2.0) for each in far) / len(far) < 0.55  # uniform in area
    assert all(abs(sum(axis) / len(axis)) < 0.2 for axis in zip(*reported, strict=True))


def test_a_silent_gps_repeats_the_last_report_with_its_noise():
    world, inbox = (initial_state(built(position_noise=2.0), 1) for _ in range(2))
    send(world, inbox)
    last = inbox.robots[0].x, inbox.robots[0].y
    world.sensors[0].active = 0
    world.mission.tick = 1

    send(world, inbox)

    assert (inbox.robots[0].x, inbox.robots[0].y) == last != (3.0, 4.0)


def rock(n, x, y, radius):
    return Obstacle(f"o{n}", Area(f"oa{n}", Coordinates(x, y), radius))


@st.composite
def fleets(draw, most):
    """Return a state with one goal for all robots, who keep clear of some of the obstacles."""
    robots = tuple(
        replace(
            robot(f"r{n}", x, y, speed=draw(st.sampled_from([0.0, 1.0, 4.0]))),
            radius=draw(st.sampled_from([1.0, 0.25, 12.5])),
            turn_rate=draw(st.sampled_from([180.0, 45.0, 5.0])),
            position_noise=draw(st.sampled_from([0.0, 1.5])),
        )
        for n, (x, y) in enumerate(draw(st.lists(points, min_size=1, max_size=most)))
    )
    rocks = tuple(
        rock(n, x, y, draw(st.floats(0.5, 60.0)))
        for n, (x, y) in enumerate(draw(st.lists(points, max_size=6)))
    )
    listed = tuple(each.id for each in rocks if draw(st.booleans()))
    names = tuple(each.id for each in robots)
    apart = draw(st.sampled_from([0.0, 3.5]))
    view = state(AvoidCollision(names, listed, apart), robots=robots, obstacles=rocks)
    for command in view.commands:
        direction = view.directions[draw(st.integers(0, 359))]
        command.heading_x, command.heading_y = direction.x, direction.y
    for obstacle in view.obstacles:
        if draw(st.integers(0, 3)) == 0:
            obstacle.x, obstacle.y = draw(points)
            view.map.is_wrong = 1
    stand(view)
    return view


def shortfalls(view):
    """Yield what share of its least distance each pair lacks: at the end of a tick, on its way."""
    n_robots = len(view.robots)
    discs = [
        (complex(each.x, each.y), complex(wake.x, wake.y), trait.radius, wake.reach)
        for each, wake, trait in zip(view.robots, view.wakes, view.traits, strict=False)
    ]
    for h in view.hazards:
        stone, wake = view.obstacles[h], view.wakes[n_robots + h]
        place = complex(stone.x, stone.y)
        discs.append((place, complex(wake.x, wake.y), stone.radius, wake.reach))
    for a, (at, was, radius, most) in enumerate(discs[:n_robots]):
        for to, had, its_radius, its_most in discs[a + 1 :]:
            off, back = to - at, (had - was) - (to - at)
            square = back.real * back.real + back.imag * back.imag
            share = -(off * back.conjugate()).real / square if square else 0.0
            on_way = abs(off + min(max(share, 0.0), 1.0) * back)
            both = radius + its_radius + view.goals[0].distance
            if excess(abs(at - was), most) > 0.0 or excess(abs(to - had), its_most) > 0.0:
                on_way = abs(off)
            yield 1.0 - abs(off) / both, 1.0 - on_way / both


def least_gap(ci, index, x, y, limit):
    """Return the gap along a heading, by looking at all robots and obstacles."""
    own, size = ci.robots[index], ci.traits[index].radius + ci.goals[0].distance
    size += guidance.berth(ci, index)
    step = guidance.pace(ci, index)
    least = limit
    for h in ci.hazards:
        stone = ci.obstacles[h]
        away = avoid_collision.closest(stone.x - own.x, stone.y - own.y, -step * x, -step * y)
        least = min(least, away - stone.radius - size)
    for other, each in enumerate(ci.robots):
        if other != index:
            pace, command = guidance.pace(ci, other), ci.commands[other]
            vx, vy = pace * command.heading_x - step * x, pace * command.heading_y - step * y
            away = avoid_collision.closest(each.x - own.x, each.y - own.y, vx, vy)
            wide = ci.traits[other].radius + guidance.berth(ci, other)
            least = min(least, away - (size + wide))
    return least


@slow
@given(fleets(most=60))
@law(150)
def test_discs_that_stand_are_too_near_exactly_where_some_pair_is(view):
    is_near = any(at_end > 1e-9 for at_end, _ in shortfalls(view))

    assert avoid_collision.violated(view, 0) is is_near


@slow
@given(fleets(most=60), steps, st.sampled_from([0.01, 1.0, 20.0]))
@law(150)
def test_discs_that_move_are_too_near_exactly_where_some_pair_is_on_its_way(view, steps, share):
    placed = (*view.robots, *view.obstacles)
    assume(all(max(abs(each.x), abs(each.y)) < 1e7 for each in placed))
    for each, (dx, dy) in zip(view.robots, steps, strict=False):
        each.x, each.y = each.x + share * dx, each.y + share * dy
    found = [on_way for _, on_way in shortfalls(view)]
    assume(all(abs(each) > 1e-6 for each in found))

    assert avoid_collision.violated(view, 0) is any(each > 0.0 for each in found)


moves = st.lists(st.tuples(st.integers(0, 59), points), max_size=12)


@slow
@given(fleets(most=60), st.lists(st.tuples(st.floats(0.5, 300.0), moves), min_size=1, max_size=6))
@law(150)
def test_gathering_finds_every_member_within_reach_once_however_robots_have_moved(view, ticks):
    goal = view.goals[0]
    for reach, moved in ticks:
        for each, command in zip(view.robots, view.commands, strict=True):
            each.x += command.speed * command.heading_x
            each.y += command.speed * command.heading_y
        for index, place in moved:
            displaced = view.robots[index % len(view.robots)]
            displaced.x, displaced.y = place
        neighbours.chart(view, goal, reach)

        for index, own in enumerate(view.robots):
            for near in (reach, 2.0 * reach):
                found = view.lookup.nearby[: neighbours.gather(view, goal, index, near)]
                assert sorted(found) == [
                    other
                    for other, each in enumerate(view.robots)
                    if other != index and abs(each.x - own.x) < near and abs(each.y - own.y) < near
                ]


@given(fleets(most=40), st.sampled_from([1.0, 80.0]), st.integers(0, 359))
@law(150)
def test_the_gap_along_a_heading_is_the_least_of_all_gaps(ci, limit, degrees):
    goal = ci.goals[0]
    heading = ci.directions[degrees]
    farthest = avoid_collision.foreseen(ci, goal)
    neighbours.chart(ci, goal, 2.0 * (farthest + 10.0))

    for index in range(len(ci.robots)):
        reach = avoid_collision.sight(ci, 0, index, limit, farthest)
        near = neighbours.gather(ci, goal, index, reach)
        found = avoid_collision.gap_along(ci, goal, index, near, heading.x, heading.y, limit)
        assert found == least_gap(ci, index, heading.x, heading.y, limit)


@pytest.mark.parametrize("n_members", [neighbours.FEW + 1, 32, 33, 100, 1000, 5000, 100_000])
def test_no_two_cells_of_a_square_share_a_bucket(n_members):
    buckets = neighbours.n_buckets(n_members)
    apart = neighbours.stride(buckets)
    side = range(neighbours.WIDEST)

    found = {(column + row * apart) % buckets for row in side for column in side}

    assert len(found) == neighbours.WIDEST**2
    assert 2 * n_members <= buckets < 4 * n_members
    assert apart % 2 == 1


@given(st.lists(st.tuples(points, st.floats(0.5, 900.0)), max_size=8), points)
@law(150)
def test_the_map_shows_every_obstacle_within_its_reach_nearest_first(placed, point):
    rocks = tuple(rock(n, *place, radius) for n, (place, radius) in enumerate(placed))
    view = state(obstacles=rocks)
    x, y = point
    cell = neighbours.cell_at(view, x, y)

    mapped = view.mapped[view.cells[cell] : view.cells[cell + 1]]

    gaps = [max(abs(each.x - x), abs(each.y - y)) - each.radius for each in view.obstacles]
    shown = {each.obstacle: each.gap for each in mapped}
    assert [each.gap for each in mapped] == sorted(shown.values())
    assert {n for n, gap in enumerate(gaps) if gap < view.map.reach} <= set(shown)
    assert all(gap <= gaps[n] for n, gap in shown.items())


def test_a_delivery_puts_displaced_obstacles_back_on_the_map():
    flown = mission(AvoidCollision(("a",), ("o0",)), obstacles=(rock(0, 40.0, 0.0, 10.0),))
    belief, inbox = (state(obstacles=flown.obstacles) for _ in range(2))
    belief.obstacles[0].x, belief.map.is_wrong = 500.0, 1

    deliver(belief, inbox, plan(flown, FaultPool("none", ()), ()))

    assert (belief.obstacles[0].x, belief.map.is_wrong) == (40.0, 0)


def carrier(*rates: int) -> Robot:
    """Return a robot with a sensor for each number of samples a tick."""
    sensors = tuple(Sensor(f"s{n}", "s", "DEPTH", 1.0, rate) for n, rate in enumerate(rates))
    return replace(robot("a", 0.0, 0.0), sensors=sensors)


@pytest.mark.parametrize("seed", [0, 1, 2**31, 2**32 - 1, 2**70])
def test_every_number_is_that_of_the_bounds_that_a_draw_of_its_own_is_not_below(seed):
    rates = (1, 2, 5, 1000)
    state = initial_state(mission(robots=(carrier(*rates),), duration=300), seed)

    found = [list(row) for row in valid_samples(state)]

    key = state.mission.seed
    assert found == sample_table(state).tolist()
    assert found == [
        [
            sum(draw(key, tick, k, PURPOSE_SAMPLES) >= bound for bound in sample_chances(rate))
            for k, rate in enumerate(rates)
        ]
        for tick in range(300)
    ]


def test_no_flight_changes_the_samples_of_those_after_it():
    with pytest.raises(ValueError, match="read-only"):
        sample_table(initial_state(mission(), 1))[0, 0] = 7


def test_a_mission_may_do_without_sensors():
    without = initial_state(mission(robots=(carrier(),)), 1)

    assert valid_samples(without) == (b"",) * 100
    assert sample_table(without).shape == (100, 0)


def test_chances_are_those_of_the_binomial_with_mean_one():
    for n in (1, 2, 5, 40, 1000):
        bounds = [bound / 2**32 for bound in sample_chances(n)]
        mean = sum(1.0 - bound for bound in bounds)
        assert abs(mean - 1.0) < 1e-8, n
        assert bounds == sorted(bounds)


@given(
    seed=st.integers(0, 2**64),
    tick=st.integers(0, 10_000_000),
    entity=st.integers(0, 2**16),
    purpose=st.integers(0, 255),
)
def test_a_draw_is_a_32_bit_integer_and_repeats(seed, tick, entity, purpose):
    key = seed_key(seed)

    value = draw(key, tick, entity, purpose)

    assert 0 <= value < 2**32
    assert draw(key, tick, entity, purpose) == value
    assert 0.0 <= uniform(key, tick, entity, purpose) < 1.0


def test_neighbouring_keys_draw_evenly():
    """Chi-square with 15 degrees of freedom stays below its 0.9999 quantile, for each key part."""
    series = {
        "seed": [choice(16, seed_key(n), 5, 3, 2) for n in range(16_000)],
        "tick": [choice(16, seed_key(1), n, 3, 2) for n in range(16_000)],
        "entity": [choice(16, seed_key(1), 5, n, 2) for n in range(16_000)],
        "both": [choice(16, seed_key(1), n % 40, n // 40, 2) for n in range(16_000)],
    }

    for part, values in series.items():
        counts = Counter(values)
        chi_square = sum((counts[value] - 1000) ** 2 / 1000 for value in range(16))
        assert chi_square < 44.26, part


def test_different_parts_of_a_key_draw_differently():
    draws = {
        draw(seed_key(seed), tick, entity, purpose)
        for seed in range(10)
        for tick in range(10)
        for entity in range(10)
        for purpose in range(10)
    }

    assert len(draws) > 9_990


def test_seeds_beyond_32_bits_differ_from_their_low_half():
    assert len({seed_key(7), seed_key(7 + 2**32), seed_key(7 + 2**64)}) == 3
