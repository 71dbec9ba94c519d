"""Distances and discs in the plane."""

import math

from mrsfi_runtime.kernel.randomness import choice, uniform
from mrsfi_runtime.kernel.state import RESERVE, State, excess, kernel


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
def well_inside(x: float, y: float, middle_x: float, middle_y: float, radius: float) -> bool:
    """Return whether a point is inside a disc, and not at its edge; for reactions."""
    return distance(x, y, middle_x, middle_y) <= (1.0 - RESERVE) * radius


@kernel
def overlap(dx: float, dy: float, reach: float) -> bool:
    """Return whether two discs overlap whose radii add up to ``reach``."""
    square = dx * dx + dy * dy
    return square < reach * reach and excess(math.sqrt(square), reach) < 0.0


@kernel
def off_segment(x: float, y: float, end_x: float, end_y: float) -> float:
    """Return the distance of a point from the segment between the origin and an end."""
    length = end_x * end_x + end_y * end_y
    share = 0.0
    if length > 0.0:
        share = min(max((x * end_x + y * end_y) / length, 0.0), 1.0)
    return distance(x, y, share * end_x, share * end_y)
