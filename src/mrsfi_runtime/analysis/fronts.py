"""Which evaluations are the most critical; Pareto fronts, and the pick by a ratio.

References
----------
Source paper, section III-A, step 6, section III-D, equation (3), and section V, RQ3.
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from math import atan2
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mrsfi_runtime.analysis.columns import Columns, Rows
from mrsfi_runtime.errors import UsageError
from mrsfi_runtime.record.store import Measure, ticks

_MOST_DRAWN = 10_000  # points of a cloud of which none is left out
_N_CELLS = 200  # of either axis, for clouds of more
_NUMBER = r"(\d+(?:\.\d+)?)"
_RATIO = re.compile(rf"\s*([^:=\s]+)\s*:\s*([^:=\s]+)\s*=\s*{_NUMBER}\s*:\s*{_NUMBER}\s*")


@dataclass(frozen=True, slots=True)
class FrontPoint:
    """A non-dominated specification: its evaluation, its violations, and how much it costs."""

    evaluation: int
    violations: tuple[float, ...]
    cost: int = 0


@dataclass(frozen=True, slots=True)
class Front:
    """The non-dominated points over chosen goals (IDs), each vector of violations once.

    The points run from few violations of the first goal to many; ``counts`` says which
    violations they are, ``minimised`` of what the front has few beside them, if of anything.
    """

    goals: tuple[str, ...]
    points: tuple[FrontPoint, ...]
    counts: str = "violations"
    minimised: str | None = None

    @property
    def aims(self) -> tuple[str, ...]:
        """What it is over."""
        return self.goals if self.minimised is None else (*self.goals, self.minimised)


@dataclass(frozen=True, slots=True)
class Ratio:
    """The wish that violations of two goals (IDs) stand as ``parts[0]`` to ``parts[1]``."""

    goals: tuple[str, str]
    parts: tuple[float, float]

    def __str__(self) -> str:
        return "{}:{}={:g}:{:g}".format(*self.goals, *self.parts)


def _undominated(vectors: NDArray[Any]) -> list[int]:
    """Return which of distinct vectors in ascending order no other dominates."""
    # Whoever dominates another has no smaller sum, and of equal ones (by rounding) comes later.
    left = np.argsort(vectors.sum(axis=1), kind="stable")[::-1]
    kept = []
    while left.size:
        kept.append(int(left[0]))
        left = left[(vectors[left] > vectors[left[0]]).any(axis=1)]
    return sorted(kept)


def _earliest(vectors: NDArray[Any]) -> NDArray[np.intp]:
    """Return the first row of each vector, the vectors in ascending order."""
    return np.unique(vectors, axis=0, return_index=True)[1]


def find_front(
    measure: Measure, columns: Columns, goals: Sequence[str], rows: Rows | None = None
) -> Front:
    """Return the front of some evaluations; of equal vectors the earliest evaluation stands.

    ``rows`` are evaluations of distinct specifications; all if left out.
    """
    rows = columns.distinct if rows is None else rows
    violations = columns.of(goals)[rows]
    costs = columns.costs[rows] if measure.minimised else np.zeros(len(rows), np.int64)
    vectors = np.column_stack([violations, -costs])
    earliest = _earliest(vectors)
    found = earliest[_undominated(vectors[earliest])]
    points = zip(rows[found], violations[found], costs[found], strict=True)
    return Front(
        goals=tuple(goals),
        points=tuple(FrontPoint(int(row), (*of.tolist(),), int(cost)) for row, of, cost in points),
        counts=str(measure),
        minimised=measure.minimised,
    )


def thinned(vectors: NDArray[Any]) -> tuple[list[tuple[float, ...]], int]:
    """Return the distinct vectors to be drawn, in ascending order, and how many are left out.

    Of more than ten thousand the smallest of each cell of a grid is drawn, whose cells are a 200th
    of the range of each goal: what is drawn of a point covers its cell.
    """
    shown = found = np.unique(vectors, axis=0)
    if len(found) > _MOST_DRAWN:
        least, most = found.min(axis=0), found.max(axis=0)
        cells = (found - least) * _N_CELLS // np.maximum(most - least, 1)
        shown = found[np.sort(_earliest(cells))]
    return [tuple(vector) for vector in shown.tolist()], len(found) - len(shown)


@dataclass(frozen=True, slots=True)
class Harm:
    """The most harm with at most so many faults, or ticks of faults, each with its evaluation."""

    cost: int
    n_violated: int
    n_violated_by: int
    violations: float
    violations_by: int


def find_harm(measure: Measure, columns: Columns) -> tuple[Harm, ...]:
    """Return the front of harm against cost: an entry for each cost from which on there is more.

    Of equally harmful specifications the one of least cost counts, then the earliest. Looked at
    are the goals that the campaign chose.
    """
    rows = columns.distinct[np.argsort(columns.costs[columns.distinct], kind="stable")]
    counts = columns.of(measure.chosen)[rows]
    n_violated = (counts > 0).sum(axis=1)
    violations = np.fromiter((sum(row.tolist()) for row in counts), counts.dtype, len(counts))
    found: dict[int, Harm] = {}
    is_wider, is_greater = is_more(n_violated), is_more(violations)
    for place in np.flatnonzero(is_wider | is_greater):
        if is_wider[place]:
            widest = int(n_violated[place]), int(rows[place])
        if is_greater[place]:
            most = violations[place].item(), int(rows[place])
        cost = int(columns.costs[rows[place]])
        found[cost] = Harm(cost, *widest, *most)
    return tuple(found.values())


def is_more(values: NDArray[Any]) -> NDArray[np.bool_]:
    """Return which values are greater than all before; the first is."""
    return np.append(True, values[1:] > np.maximum.accumulate(values)[:-1])[: len(values)]


@dataclass(frozen=True, slots=True)
class Pick:
    """The point of a front over ``goals`` nearest to a ratio; ``None`` if none violates them."""

    ratio: Ratio
    point: FrontPoint | None
    goals: tuple[str, ...]

    @property
    def offered_in_words(self) -> str:
        """The point's own ratio."""
        if self.point is None:
            return ""
        first, second = (self.point.violations[self.goals.index(goal)] for goal in self.ratio.goals)
        return f", which is {first / second:.3g}:1" if second else f", which is {first:g}:0"

    def in_words(self, measure: Measure) -> str:
        """Return in a phrase which evaluation it is, and what it offers of the ratio's goals."""
        if self.point is None:
            return f"nearest to {self.ratio}: none, because no specification violates these goals"
        violations = dict(zip(self.goals, self.point.violations, strict=True))
        found = ", ".join(f"{goal} {ticks(violations[goal])}" for goal in self.ratio.goals)
        return (
            f"nearest to {self.ratio}: evaluation {self.point.evaluation} with {found} "
            f"({measure}){self.offered_in_words}"
        )


def parse_ratio(text: str) -> Ratio:
    """Return the ratio that ``g3:g1=2:1`` asks for; any other text is a ``UsageError``."""
    match = _RATIO.fullmatch(text)
    if match is not None:
        first, second = match[1], match[2]
        parts = (float(match[3]), float(match[4]))
        if first != second and any(parts):
            return Ratio((first, second), parts)
    raise UsageError(
        f"found ratio '{text}'; expected two goals and two numbers, not both 0, such as 'g3:g1=2:1'"
    )


def nearest_ratio(front: Front, ratio: Ratio) -> FrontPoint | None:
    """Return the point of the front that comes nearest to a ratio (paper, section V, RQ3).

    Nearest is the smallest angle between the two goals' violations and the two parts of the ratio,
    as vectors; of equal angles the point with more violations of the two goals. Points that violate
    neither goal have no ratio: ``None`` if all are such.
    """
    first, second = (front.goals.index(goal) for goal in ratio.goals)
    direction = atan2(ratio.parts[1], ratio.parts[0])

    def distance(point: FrontPoint) -> tuple[float, float, int]:
        along, across = point.violations[first], point.violations[second]
        return abs(atan2(across, along) - direction), -(along + across), point.evaluation

    candidates = [p for p in front.points if p.violations[first] or p.violations[second]]
    return min(candidates, key=distance, default=None)
