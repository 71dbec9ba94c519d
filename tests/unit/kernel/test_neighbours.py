"""What the grid and the map find is what looking at all robots and all obstacles finds."""

from itertools import combinations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mrsfi_runtime.api import AvoidCollision
from mrsfi_runtime.kernel import geometry, guidance, neighbours
from mrsfi_runtime.kernel.effects import deliver
from mrsfi_runtime.kernel.goal_tasks import avoid_collision
from mrsfi_runtime.kernel.injections import plan
from mrsfi_runtime.model.faults import FaultPool
from mrsfi_runtime.model.mission import Area, Coordinates, Obstacle
from tests.support.world import mission, robot, state
from tests.tiers import law, slow

places = st.floats(-150.0, 150.0) | st.sampled_from([0.0, 2.0, 16.0, -1e300, 1e300, 1e6])
points = st.tuples(places, places)


def rock(n, x, y, radius):
    return Obstacle(f"o{n}", Area(f"oa{n}", Coordinates(x, y), radius))


@st.composite
def fleets(draw, most):
    """Return a state with one goal for all robots, who keep clear of some of the obstacles."""
    robots = tuple(
        robot(f"r{n}", x, y, speed=draw(st.sampled_from([0.0, 1.0, 4.0])))
        for n, (x, y) in enumerate(draw(st.lists(points, min_size=1, max_size=most)))
    )
    rocks = tuple(
        rock(n, x, y, draw(st.floats(0.5, 60.0)))
        for n, (x, y) in enumerate(draw(st.lists(points, max_size=6)))
    )
    listed = tuple(each.id for each in rocks if draw(st.booleans()))
    names = tuple(each.id for each in robots)
    view = state(AvoidCollision(names, listed), robots=robots, obstacles=rocks)
    for command in view.commands:
        direction = view.directions[draw(st.integers(0, 359))]
        command.heading_x, command.heading_y = direction.x, direction.y
    for obstacle in view.obstacles:
        if draw(st.integers(0, 3)) == 0:
            obstacle.x, obstacle.y = draw(points)
            view.map.is_wrong = 1
    return view


def overlapping(view):
    """Say whether two discs overlap, by looking at all pairs."""
    robots = [(each.x, each.y) for each in view.robots]
    pairs = [(*first, *second, 2.0) for first, second in combinations(robots, 2)]
    for h in view.hazards:
        stone = view.obstacles[h]
        pairs += [(*each, stone.x, stone.y, stone.radius + 1.0) for each in robots]
    return any(geometry.overlap(bx - ax, by - ay, reach) for ax, ay, bx, by, reach in pairs)


def least_gap(ci, index, x, y, limit):
    """Return the clearance of a heading, by looking at all robots and obstacles."""
    own = ci.robots[index]
    step = guidance.pace(ci, index)
    least = limit
    for h in ci.hazards:
        stone = ci.obstacles[h]
        away = avoid_collision.closest(stone.x - own.x, stone.y - own.y, -step * x, -step * y)
        least = min(least, away - stone.radius - 1.0)
    for other, each in enumerate(ci.robots):
        if other != index:
            pace, command = guidance.pace(ci, other), ci.commands[other]
            vx, vy = pace * command.heading_x - step * x, pace * command.heading_y - step * y
            least = min(
                least, avoid_collision.closest(each.x - own.x, each.y - own.y, vx, vy) - 2.0
            )
    return least


@slow
@given(fleets(most=60))
@law(150)
def test_discs_overlap_exactly_where_some_pair_does(view):
    assert avoid_collision.violated(view, 0) is overlapping(view)


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
def test_the_clearance_of_a_heading_is_the_least_of_all_gaps(ci, limit, degrees):
    goal = ci.goals[0]
    heading = ci.directions[degrees]
    farthest = max(10 * guidance.pace(ci, index) for index in range(len(ci.robots)))
    neighbours.chart(ci, goal, 2.0 * (farthest + 10.0))

    for index in range(len(ci.robots)):
        near = neighbours.gather(ci, goal, index, avoid_collision.sight(ci, index, limit, farthest))
        found = avoid_collision.clearance(ci, goal, index, near, heading.x, heading.y, limit)
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
