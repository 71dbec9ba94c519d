"""Which obstacles are near a place: looked up in a map of where the model puts them.

The map divides the square around the mission area into cells, each with the obstacles that
are within reach of it, the nearest first; cells at the edge stand for all that is beyond.
Obstacles that are believed elsewhere are few, and looked at one by one.
"""

from dataclasses import dataclass
from functools import lru_cache
from operator import attrgetter

from mrsfi_runtime.kernel.compiling import kernel
from mrsfi_runtime.kernel.state import GoalState, MappedState, MapState, State

SIDE = 32
"""Cells along a side of the map."""

SLACK = 0.001
"""By what a cell counts as larger than it is, in cells, so that no rounding hides an obstacle."""

_LEAST_ROOM = 256  # entries of a map, times a power of 4: an obstacle that moves does not recompile


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


@dataclass(frozen=True, slots=True)
class Survey:
    """What a map is drawn from.

    ``left`` is its lower left corner, ``obstacles`` have centre and radius; see ``MapState``.
    """

    left: tuple[float, float]
    cells_per_unit: float
    reach: float
    obstacles: tuple[tuple[float, float, float], ...]


@lru_cache(maxsize=16)
def drawn(survey: Survey) -> tuple[tuple[int, ...], tuple[MappedState, ...]]:
    """Return ``State.cells`` and ``State.mapped``, the same for every state of a mission."""
    found: list[list[MappedState]] = [[] for _ in range(SIDE * SIDE)]
    for index, (x, y, radius) in enumerate(survey.obstacles):
        across = _gaps(survey, x - survey.left[0], radius)
        along = _gaps(survey, y - survey.left[1], radius)
        for row, low in along:
            for column_, near in across:
                found[SIDE * row + column_].append(MappedState(index, max(low, near) - radius))
    cells = [0]
    mapped: list[MappedState] = []
    for shown in found:
        mapped.extend(sorted(shown, key=attrgetter("gap")))
        cells.append(len(mapped))
    room = _LEAST_ROOM
    while room < len(mapped):
        room *= 4
    mapped.extend([MappedState(0, 0.0)] * (room - len(mapped)))
    return tuple(cells), tuple(mapped)


def _gaps(survey: Survey, offset: float, radius: float) -> list[tuple[int, float]]:
    """Return the columns, or rows, within reach of a disc, and how far from its centre they are."""
    place = offset * survey.cells_per_unit
    gaps = [max(n - SLACK - place, place - n - 1 - SLACK, 0.0) for n in range(SIDE)]
    gaps[0] = max(place - 1 - SLACK, 0.0)
    gaps[-1] = max(SIDE - 1 - SLACK - place, 0.0)
    limit = (survey.reach + radius) * survey.cells_per_unit
    return [(n, gap / survey.cells_per_unit) for n, gap in enumerate(gaps) if gap < limit]
