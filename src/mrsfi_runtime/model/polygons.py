"""Polygons in the plane: how far a point, or a way, is from one, and a point far inside it.

Corners are records with ``x`` and ``y``, in order along the edge, clockwise or not. A polygon is a
range of a list of corners, because compiled code keeps all corners of a mission in one table. The
distance functions keep to the common subset of ``kernel.state`` and are part of the kernel.

Distances are signed: 0 or more outside the edges, 0 or less inside.
"""

import math
from collections.abc import Sequence
from itertools import combinations, pairwise
from typing import Protocol

MOST_CORNERS = 64

AHEAD = 1.0 + 1e-9  # factor by which a point must be farther inside than others to be preferred


class Corner(Protocol):
    """A point."""

    @property
    def x(self) -> float:
        """The first coordinate."""

    @property
    def y(self) -> float:
        """The second coordinate."""


def off_segment(x: float, y: float, end_x: float, end_y: float) -> float:
    """Return the distance of a point from the segment between the origin and an end."""
    return math.sqrt(square_off(x, y, end_x, end_y))


def square_off(x: float, y: float, end_x: float, end_y: float) -> float:
    """Return the square of the distance of ``off_segment``."""
    length = end_x * end_x + end_y * end_y
    along = x * end_x + y * end_y
    share = 1.0
    if along <= 0.0:  # as it is without length, too
        share = 0.0
    elif along < length:
        share = along / length
    dx, dy = share * end_x - x, share * end_y - y
    return dx * dx + dy * dy


def off_polygon(corners: Sequence[Corner], first: int, n: int, x: float, y: float) -> float:
    """Return the distance of a point from the edges of a polygon, negative if it is inside."""
    least = math.inf
    is_inside = False
    before = corners[first + n - 1]
    for k in range(first, first + n):
        after = corners[k]
        edge_x, edge_y = after.x - before.x, after.y - before.y
        dx, dy = x - before.x, y - before.y
        least = min(least, square_off(dx, dy, edge_x, edge_y))
        if (before.y > y) != (after.y > y) and (edge_x * dy > edge_y * dx) == (edge_y > 0.0):
            is_inside = not is_inside
        before = after
    return -math.sqrt(least) if is_inside else math.sqrt(least)


def off_way(
    corners: Sequence[Corner], first: int, n: int, x: float, y: float, way_x: float, way_y: float
) -> float:
    """Return the least distance from a polygon on a straight way from a point.

    If the way meets the polygon, only the distances of its two ends count, and 0.
    """
    ends = off_polygon(corners, first, n, x, y)
    if way_x == 0.0 and way_y == 0.0:
        return ends
    ends = min(ends, off_polygon(corners, first, n, x + way_x, y + way_y))
    if ends <= 0.0:
        return ends
    least = math.inf
    before = corners[first + n - 1]
    for k in range(first, first + n):
        after = corners[k]
        if crosses(before, after, x, y, way_x, way_y):
            return 0.0
        least = min(least, square_off(after.x - x, after.y - y, way_x, way_y))
        before = after
    return min(ends, math.sqrt(least))


def crosses(before: Corner, after: Corner, x: float, y: float, way_x: float, way_y: float) -> bool:
    """Return whether the ends of an edge, and of a way from a point, are on either side."""
    edge_x, edge_y = after.x - before.x, after.y - before.y
    dx, dy = x - before.x, y - before.y
    is_before_left = way_y * dx > way_x * dy
    is_after_left = way_y * (dx - edge_x) > way_x * (dy - edge_y)
    is_start_left = edge_x * dy > edge_y * dx
    is_end_left = edge_x * (dy + way_y) > edge_y * (dx + way_x)
    return is_before_left != is_after_left and is_start_left != is_end_left


def near(corners: Sequence[Corner]) -> float:
    """Return the distance that counts as none in a polygon: a billionth of its extent."""
    xs, ys = [each.x for each in corners], [each.y for each in corners]
    return 1e-9 * (max(xs) - min(xs) + (max(ys) - min(ys)))


def meeting(corners: Sequence[Corner]) -> tuple[int, int] | None:
    """Return the first two edges that meet elsewhere than at a common corner, by number from 0.

    Edge k leads from corner k to the next. Edges next to one without a length meet it.
    """
    least, edges = near(corners), [*pairwise((*corners, corners[0]))]
    for (k, one), (n, other) in combinations(enumerate(edges), 2):
        ends = [(*one, end) for end in other if end is not one[0] and end is not one[1]]
        ends += [(*other, end) for end in one if end is not other[0] and end is not other[1]]
        is_met = any(
            off_segment(p.x - a.x, p.y - a.y, b.x - a.x, b.y - a.y) <= least for a, b, p in ends
        )
        (a, b), (c, d) = one, other
        if is_met or (len(ends) == 4 and crosses(a, b, c.x, c.y, d.x - c.x, d.y - c.y)):
            return k, n
    return None


def middle(corners: Sequence[Corner]) -> tuple[float, float]:
    """Return a point far inside a polygon.

    It is the middle of all corners' extent, or, for two neighbouring heights of corners, the middle
    of the longest stretch inside halfway between them: of these the farthest from the edges.
    """
    xs, heights = [each.x for each in corners], sorted({each.y for each in corners})
    spots = [((min(xs) + max(xs)) / 2.0, (heights[0] + heights[-1]) / 2.0)]
    for low, high in pairwise(heights):
        y = (low + high) / 2.0
        edges = pairwise((*corners, corners[0]))
        meets = sorted(
            a.x + (y - a.y) / (b.y - a.y) * (b.x - a.x) for a, b in edges if (a.y > y) != (b.y > y)
        )
        stretches = [*zip(meets[::2], meets[1::2], strict=True)]
        if stretches:
            left, right = max(stretches, key=lambda ends: ends[1] - ends[0])
            spots.append(((left + right) / 2.0, y))
    found, depth = spots[0], 0.0
    for spot in spots:
        inside = -off_polygon(corners, 0, len(corners), *spot)
        if inside > depth * AHEAD:
            found, depth = spot, inside
    return found
