"""How far robots turn in a tick, and how far off they report themselves."""

import math
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mrsfi_runtime.kernel.commands import turned
from mrsfi_runtime.kernel.effects import issue, send
from mrsfi_runtime.kernel.flight import initial_state
from mrsfi_runtime.kernel.injections import plan
from mrsfi_runtime.model.faults import FaultPool
from tests.support.world import mission, robot
from tests.tiers import law

RATES = st.floats(1e-6, 180.0) | st.sampled_from((1e-9, 90.0, 179.9999999, 180.0))
ANGLES = st.floats(-180.0, 180.0) | st.sampled_from((-180.0, -90.0, 0.0, 90.0, 180.0))


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
