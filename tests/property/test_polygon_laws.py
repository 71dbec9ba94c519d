"""Laws of polygons: how far points and ways are from them, against another way to reckon it."""

import math
from functools import partial

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from mrsfi_runtime.model.mission import Coordinates, polygon
from mrsfi_runtime.model.polygons import meeting, middle, off_polygon, off_way
from tests.independent import polygon as other
from tests.tiers import law

TURN = 2.0 * math.pi


def around(radii, turns=(), sign=1.0):
    """Return corners at some distances from the origin, in equal turns or nearly so."""
    share = TURN / len(radii) * sign
    shifts = turns or [0.0] * len(radii)
    return tuple(
        Coordinates(away * math.cos((k + shift) * share), away * math.sin((k + shift) * share))
        for k, (away, shift) in enumerate(zip(radii, shifts, strict=True))
    )


@st.composite
def stars(draw):
    """Draw corners, convex or not, that wind once around the origin, either way."""
    n = draw(st.sampled_from([3, 4, 5, 9, 64]))
    radii = draw(st.lists(st.floats(0.1, 10.0), min_size=n, max_size=n))
    turns = draw(st.lists(st.floats(0.0, 0.4), min_size=n, max_size=n))
    return around(radii, turns, draw(st.sampled_from([1.0, -1.0])))


numbers = st.floats(-15.0, 15.0)
points = st.tuples(numbers, numbers)
disc = partial(around, [10.0] * 64)


def off(corners, x, y):
    return off_polygon(corners, 0, len(corners), x, y)


def pairs(corners):
    return [(each.x, each.y) for each in corners]


@law(300)
@given(stars(), points)
def test_a_point_is_inside_what_the_corners_wind_around(corners, spot):
    found, expected = off(corners, *spot), other.off_edges(pairs(corners), *spot)

    assert found == pytest.approx(expected, abs=1e-9)


@law(200)
@given(points)
def test_64_corners_are_nearly_a_disc(spot):
    found, expected = off(disc(), *spot), math.hypot(*spot) - 10.0

    assert expected - 1e-9 <= found <= expected + 10.0 * (1.0 - math.cos(TURN / 128.0)) + 1e-9


@law(200)
@given(points, points)
def test_a_way_past_64_corners_is_as_near_as_past_a_disc(start, end):
    way = end[0] - start[0], end[1] - start[1]
    found = off_way(disc(), 0, 64, *start, *way)
    expected = other.off_edge(start, end, 0.0, 0.0) - 10.0

    if expected > 0.0:
        assert expected - 1e-9 <= found <= expected + 10.0 * (1.0 - math.cos(TURN / 128.0)) + 1e-9
    else:
        assert found <= 10.0 * (1.0 - math.cos(TURN / 128.0)) + 1e-9


@law(200)
@given(stars(), points, points)
def test_a_way_is_as_near_as_its_nearest_point(corners, start, end):
    dx, dy = end[0] - start[0], end[1] - start[1]
    found = off_way(corners, 0, len(corners), *start, dx, dy)
    steps = [k / 200 for k in range(201)]
    sampled = min(off(corners, start[0] + k * dx, start[1] + k * dy) for k in steps)

    gap = math.hypot(dx, dy) / 400 + 1e-9
    assert sampled - gap <= found if sampled > 0.0 else found <= gap
    assert found <= sampled + 1e-9 or sampled < 0.0
    ends = (off(corners, *start), off(corners, start[0] + dx, start[1] + dy))
    assert found <= min(ends)
    assert off_way(corners, 0, len(corners), *start, 0.0, 0.0) == ends[0]


@law(200)
@given(stars(), points, st.integers(-8, 8))
def test_what_is_twice_as_large_is_twice_as_far(corners, spot, power):
    by = 2.0**power
    large = tuple(Coordinates(by * each.x, by * each.y) for each in corners)

    assert off(large, by * spot[0], by * spot[1]) == by * off(corners, *spot)
    assert middle(large) == tuple(by * each for each in middle(corners))


@law(200)
@given(stars(), points)
def test_the_centre_is_inside_and_the_radius_reaches_all_corners(corners, shift):
    moved = tuple(Coordinates(each.x + shift[0], each.y + shift[1]) for each in corners)
    assume(meeting(moved) is None)
    area = polygon("a", moved)

    assert off(moved, area.center.x, area.center.y) < 0.0
    assert area.radius == max(math.sqrt(x * x + y * y) for x, y in area.offsets)
    assert (area.center.x, area.center.y) == other.middle(pairs(moved))[:2]


SPIRAL = [(0, 0), (9, 0), (9, 9), (1, 9), (1, 3), (6, 3), (6, 6), (5, 6), (5, 4), (2, 4), (2, 8)]
SHAPES = {
    "rack": ([(0, 0), (10, 0), (10, 2), (0, 2)], (5, 1)),
    "slanted": ([(0, 0), (8, 0), (0, 8)], (2, 4)),
    "corner": ([(0, 0), (9, 0), (9, 1), (1, 1), (1, 9), (0, 9)], (4.5, 0.5)),
    "hook": ([(0, 0), (1, 0), (1, 8), (9, 8), (9, 9), (0, 9)], (0.5, 4)),
    "spiral": ([*SPIRAL, (8, 8), (8, 1), (0, 1)], (4.5, 0.5)),
}


@pytest.mark.parametrize("name", SHAPES)
def test_the_centre_of_some_shapes(name):
    corners, expected = SHAPES[name]
    corners = [Coordinates(*map(float, each)) for each in corners]

    assert meeting(corners) is None
    assert middle(corners) == expected


@pytest.mark.parametrize(
    ("corners", "expected"),
    [
        ([(0, 0), (9, 9), (9, 0), (0, 9)], (0, 2)),  # crosses itself
        ([(0, 0), (9, 0), (9, 9), (4, 0), (0, 9)], (0, 2)),  # a corner on an edge
        ([(0, 0), (9, 0), (9, 0), (9, 9)], (0, 1)),  # no length
        ([(0, 0), (9, 0), (4, 0), (4, 9)], (0, 1)),  # back on itself
        ([(0, 0), (4, 0), (9, 0)], (0, 2)),  # no area
        ([(0, 0), (4, 0), (9, 0), (9, 9)], None),  # a corner that turns nothing
    ],
)
def test_edges_that_meet(corners, expected):
    assert meeting([Coordinates(*map(float, each)) for each in corners]) == expected
