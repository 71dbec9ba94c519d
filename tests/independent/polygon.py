"""Polygons, by [S Polygons]: inside is what the corners wind around."""

import math
from collections.abc import Iterator, Sequence
from itertools import pairwise

Point = Sequence[float]


def edges(corners: Sequence[Point]) -> Iterator[tuple[Point, Point]]:
    yield from zip(corners, (*corners[1:], corners[0]), strict=True)


def is_inside(corners: Sequence[Point], x: float, y: float) -> bool:
    """Return whether the corners wind around a point."""
    turns = 0.0
    for a, b in edges(corners):
        (ax, ay), (bx, by) = ((each[0] - x, each[1] - y) for each in (a, b))
        turns += math.atan2(ax * by - ay * bx, ax * bx + ay * by)
    return abs(turns) > math.pi


def off_edge(a: Point, b: Point, x: float, y: float) -> float:
    """Return the distance of a point from an edge."""
    way = b[0] - a[0], b[1] - a[1]
    long = way[0] * way[0] + way[1] * way[1]
    share = ((x - a[0]) * way[0] + (y - a[1]) * way[1]) / long if long else 0.0
    share = max(0.0, min(share, 1.0))
    return math.hypot(a[0] + share * way[0] - x, a[1] + share * way[1] - y)


def off_edges(corners: Sequence[Point], x: float, y: float) -> float:
    """Return "the distance from the nearest edge", negative inside."""
    away = min(off_edge(a, b, x, y) for a, b in edges(corners))
    return -away if is_inside(corners, x, y) else away


def meets(a: Point, b: Point, c: Point, d: Point) -> bool:
    """Return whether two segments have a point in common, unless they are parallel."""
    (px, py), (qx, qy) = (b[0] - a[0], b[1] - a[1]), (d[0] - c[0], d[1] - c[1])
    flat = px * qy - py * qx
    if flat == 0.0:
        return False
    x, y = c[0] - a[0], c[1] - a[1]
    return 0.0 <= (x * qy - y * qx) / flat <= 1.0 and 0.0 <= (x * py - y * px) / flat <= 1.0


def off_way(corners: Sequence[Point], a: Point, b: Point) -> float:
    """Return the "least distance of a robot from a polygon on a way"."""
    ends = min(off_edges(corners, *a), off_edges(corners, *b))
    if any(meets(a, b, c, d) for c, d in edges(corners)):
        return min(ends, 0.0)
    return min(ends, *(off_edge(a, b, *corner) for corner in corners))


def middle(corners: Sequence[Point]) -> tuple[float, float, float]:
    """Return the centre of a polygon whose model gives none."""
    low, *_, high = levels = sorted({each[1] for each in corners})
    left, right = (pick(each[0] for each in corners) for pick in (min, max))
    candidates = [((left + right) / 2, (low + high) / 2)]
    for below, above in pairwise(levels):
        y = (below + above) / 2
        crossings = [
            a[0] + (y - a[1]) / (b[1] - a[1]) * (b[0] - a[0])
            for a, b in edges(corners)
            if min(a[1], b[1]) <= y < max(a[1], b[1])
        ]
        crossings.sort()
        widest = -1.0
        for left, right in zip(crossings[::2], crossings[1::2], strict=True):
            if right - left > widest:
                widest, x = right - left, (left + right) / 2
        if crossings:
            candidates.append((x, y))
    best, deepest = candidates[0], 0.0
    for spot in candidates:
        depth = -off_edges(corners, *spot)
        if depth > deepest * (1 + 1e-9):
            best, deepest = spot, depth
    return (*best, 0.0)
