"""Which obstacles are near a place: looked up in a map of where the model puts them.

The map divides the square around the mission area into cells, each with the obstacles that
are within reach of it, the nearest first; cells at the edge stand for all that is beyond.
Obstacles that are believed elsewhere are few, and looked at one by one.
"""

from functools import lru_cache
from operator import attrgetter

from mrsfi_runtime.kernel.compiling import kernel
from mrsfi_runtime.kernel.state import GoalState, MappedState, MapState, State
from mrsfi_runtime.model.mission import Area, Obstacle

SIDE = 32
"""Cells along a side of the map."""

SLACK = 0.001
"""By what a cell counts as larger than it is, in cells, so that no rounding hides an obstacle."""


@kernel
def column(map_: MapState, offset: float) -> int:
    """Return the column, or row, of a point so far from the map's left, or lower, edge."""
    return int(min(max(offset * map_.cells_per_unit, 0.0), SIDE - 1.0))


@kernel
def cell_at(view: State, x: float, y: float) -> int:
    """Return the cell of the map that stands for a point; its row of cells lies along x."""
    map_ = view.map
    return SIDE * column(map_, y - map_.y) + column(map_, x - map_.x)


@kernel
def is_listed(view: State, goal: GoalState, index: int) -> bool:
    """Return whether an obstacle is among those of a goal."""
    for h in range(goal.first_hazard, goal.first_hazard + goal.n_hazards):
        if view.hazards[h] == index:
            return True
    return False


@kernel
def is_displaced(view: State, index: int) -> bool:
    """Return whether an obstacle is believed elsewhere than where the model puts it."""
    obstacle = view.obstacles[index]
    return obstacle.x != obstacle.model_x or obstacle.y != obstacle.model_y


def mapped(
    area: Area, obstacles: tuple[Obstacle, ...], reach: float
) -> tuple[MapState, tuple[int, ...], tuple[MappedState, ...]]:
    """Return ``State.map``, ``.cells`` and ``.mapped``; for ``reach`` see ``MapState``."""
    x, y = float(area.center.x) - area.radius, float(area.center.y) - area.radius
    map_ = MapState(x, y, SIDE / max(2.0 * area.radius, 1.0), reach, 0)
    discs = tuple(obstacle.area for obstacle in obstacles)
    return map_, *_drawn(x, y, map_.cells_per_unit, reach, discs)


@lru_cache(maxsize=16)
def _drawn(
    x: float, y: float, cells_per_unit: float, reach: float, discs: tuple[Area, ...]
) -> tuple[tuple[int, ...], tuple[MappedState, ...]]:
    """Return cells, and what is mapped there; the same for every state of a mission."""
    found: list[list[MappedState]] = [[] for _ in range(SIDE * SIDE)]
    for index, disc in enumerate(discs):
        across = _gaps(disc.center.x - x, cells_per_unit, reach + disc.radius)
        along = _gaps(disc.center.y - y, cells_per_unit, reach + disc.radius)
        for row, low in along:
            for column_, near in across:
                gap = max(low, near) - disc.radius
                found[SIDE * row + column_].append(MappedState(index, gap))
    cells = [0]
    shown: list[MappedState] = []
    for each in found:
        shown.extend(sorted(each, key=attrgetter("gap")))
        cells.append(len(shown))
    return tuple(cells), tuple(shown)


def _gaps(offset: float, cells_per_unit: float, limit: float) -> list[tuple[int, float]]:
    """Return the columns, or rows, nearer than a limit to a point, and how far from it they are."""
    place = offset * cells_per_unit
    gaps = [max(n - SLACK - place, place - n - 1 - SLACK, 0.0) for n in range(SIDE)]
    gaps[0] = max(place - 1 - SLACK, 0.0)
    gaps[-1] = max(SIDE - 1 - SLACK - place, 0.0)
    return [(n, gap / cells_per_unit) for n, gap in enumerate(gaps) if gap < limit * cells_per_unit]
