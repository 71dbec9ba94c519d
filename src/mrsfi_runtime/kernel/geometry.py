"""Distances, discs and polygons in the plane.

The distance of a point from the centre of a polygon counts as its radius plus the distance from its
edges, or minus that inside, so that the rules for discs hold for polygons as they stand.
"""

import math

from mrsfi_runtime.kernel.injections import TriggerState
from mrsfi_runtime.kernel.randomness import choice, uniform
from mrsfi_runtime.kernel.state import RESERVE, AreaState, State, excess, kernel
from mrsfi_runtime.model.polygons import crosses, off_polygon, off_segment, off_way, square_off

for each in (crosses, off_polygon, off_segment, off_way, square_off):
    kernel(each)


@kernel
def distance(x: float, y: float, to_x: float, to_y: float) -> float:
    """Return the distance of two points in the plane."""
    dx, dy = to_x - x, to_y - y
    return math.sqrt(dx * dx + dy * dy)


@kernel
def scattered(
    state: State, x: float, y: float, radius: float, entity: int, purpose: int
) -> tuple[float, float]:
    """Return a random point of a disc, uniform: radius × √u along a direction.

    The direction is drawn under ``purpose + 1``.
    """
    seed = state.mission.seed
    tick = state.mission.tick
    direction = state.directions[choice(len(state.directions), seed, tick, entity, purpose + 1)]
    reach = radius * math.sqrt(uniform(seed, tick, entity, purpose))
    return x + reach * direction.x, y + reach * direction.y


@kernel
def inside(x: float, y: float, middle_x: float, middle_y: float, radius: float) -> bool:
    """Return whether a point is inside a disc or at its edge."""
    dx, dy = x - middle_x, y - middle_y
    square = dx * dx + dy * dy
    return square < radius * radius or excess(math.sqrt(square), radius) <= 0.0


@kernel
def well_inside(
    x: float, y: float, middle_x: float, middle_y: float, radius: float, edge: float = 0.0
) -> bool:
    """Return whether a point is inside a disc, and farther than ``edge`` from its edge."""
    dx, dy, most = x - middle_x, y - middle_y, (1.0 - RESERVE) * radius - edge
    square = dx * dx + dy * dy
    return most >= 0.0 and (square < most * most or math.sqrt(square) <= most)


@kernel
def in_area(view: State, area: AreaState | TriggerState, x: float, y: float) -> bool:
    """Return whether a point is inside an area, or that of a trigger, or at its edge."""
    if area.n_corners == 0:
        return inside(x, y, area.x, area.y, area.radius)
    return excess(area.radius - depth_in_area(view, area, x, y), area.radius) <= 0.0


@kernel
def depth_in_area(view: State, area: AreaState | TriggerState, x: float, y: float) -> float:
    """Return how far inside an area a point is."""
    if area.n_corners == 0:
        return area.radius - distance(x, y, area.x, area.y)
    first, n = area.first_corner, area.n_corners
    return -off_polygon(view.corners, first, n, x - area.x, y - area.y)


@kernel
def well_in_area(view: State, area: AreaState, x: float, y: float, edge: float) -> bool:
    """Return whether a point is inside an area, and farther than ``edge`` from its edge."""
    if area.n_corners == 0:
        return well_inside(x, y, area.x, area.y, area.radius, edge)
    return depth_in_area(view, area, x, y) >= RESERVE * area.depth + edge
