"""Discs: the first that holds a point, as asking every disc in order would find it."""

import math
import random

import pytest

from m2t.models import constraints
from m2t.models.constraints import Discs, Point, distance

SPREADS = (0.0, 1.0, 5.0, 100.0, 1e12)
RADII = (2.0, 1.5, 3.0, 50.0, 4e11, math.nextafter(2.0, 0.0))


def _first(discs: list[tuple[Point, float]], point: Point) -> int | None:
    found = (n for n, (center, radius) in enumerate(discs) if distance(point, center) < radius)
    return next(found, None)


@pytest.mark.parametrize("spread", SPREADS)
def test_first_disc_is_that_of_asking_all_in_order(spread):
    draw = random.Random(f"discs {spread}")
    found = Discs()
    discs: list[tuple[Point, float]] = []

    for number in range(400):
        point = (draw.uniform(-spread, spread), draw.uniform(-spread, spread))

        assert found.first_around(point) == _first(discs, point)

        radius = draw.choice(RADII)
        found.add(number, point, radius)
        discs.append((point, radius))


@pytest.mark.parametrize("step", [(2.0, 0.0), (0.0, -2.0), (-1.2, 1.6)])
def test_point_on_the_edge_lies_outside(step):
    found = Discs()
    found.add("disc", (1.0, 1.0), 2.0)

    assert found.first_around((1.0 + step[0], 1.0 + step[1])) is None
    assert found.first_around((1.0 + 0.99 * step[0], 1.0 + 0.99 * step[1])) == "disc"


def test_asks_few_discs_of_many_that_lie_apart(monkeypatch):
    n_asked = 0

    def counted(one: Point, other: Point) -> float:
        nonlocal n_asked
        n_asked += 1
        return distance(one, other)

    monkeypatch.setattr(constraints, "distance", counted)
    found = Discs()
    for number in range(2_000):
        point = (10.0 * (number % 50), 10.0 * (number // 50))
        found.first_around(point)
        found.add(number, point, 2.0)

    assert n_asked < 2_000
