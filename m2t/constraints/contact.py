"""Find which disc a point first lies in, without asking every disc."""

import math
from collections import defaultdict
from collections.abc import Callable
from itertools import product
from typing import Generic, TypeAlias, TypeVar

Point: TypeAlias = tuple[float, float]
T = TypeVar("T")


class Discs(Generic[T]):
    """Discs in the plane, in order, each for an element; ``distance`` is that of two points.

    A disc lies in one cell of a grid whose cells are as wide as its radius or wider, up to twice,
    so that whatever it holds is in that cell or one beside it. Discs of like radius share a
    grid; there are as many grids as there are magnitudes of radii.
    """

    def __init__(self, distance: Callable[[Point, Point], float]) -> None:
        self._distance = distance
        self._discs: list[tuple[T, Point, float]] = []
        self._grids: dict[float, dict[tuple[int, int], list[int]]] = {}

    def add(self, element: T, center: Point, radius: float) -> None:
        """Add a disc after all others."""
        width = 2.0 ** math.frexp(radius)[1]
        cells = self._grids.setdefault(width, defaultdict(list))
        cells[_cell(center, width)].append(len(self._discs))
        self._discs.append((element, center, radius))

    def first_around(self, point: Point) -> T | None:
        """Return the element of the first disc that a point lies in, not on its edge."""
        found = []
        for width, cells in self._grids.items():
            x, y = _cell(point, width)
            for dx, dy in product((-1, 0, 1), repeat=2):
                near = cells.get((x + dx, y + dy), ())
                found += next(([number] for number in near if self._holds(number, point)), [])
        return self._discs[min(found)][0] if found else None

    def _holds(self, number: int, point: Point) -> bool:
        _, center, radius = self._discs[number]
        return self._distance(point, center) < radius


def _cell(point: Point, width: float) -> tuple[int, int]:
    return math.floor(point[0] / width), math.floor(point[1] / width)
