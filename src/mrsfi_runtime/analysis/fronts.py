"""Read all evaluations of a campaign as arrays, and find their fronts.

``Columns`` stores an evaluation in tens of bytes, not as an object. Eight bytes of a hash over its
timed faults, in any order, identify a specification. Among a million specifications, two share a
hash with probability 3e-8; then one of them is not counted.

``Columns`` reads, ``find_front`` and ``find_harm`` search, and ``nearest_ratio`` picks a point.

References
----------
Source paper, section III-A, step 6, section III-D, equation (3), and section V, RQ3.
"""

import re
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from hashlib import blake2b
from math import atan2
from typing import Any, Self, TypeAlias

import numpy as np
from numpy.typing import NDArray

from mrsfi_runtime.analysis.tables import ticks
from mrsfi_runtime.errors import UsageError
from mrsfi_runtime.record import database
from mrsfi_runtime.record.store import CampaignStore, Measure

Rows: TypeAlias = NDArray[np.intp]
"""Indexes of evaluations, ascending."""


@dataclass(frozen=True, slots=True)
class Columns:
    """The evaluations of a campaign, each of which has a row.

    ``fitness`` ranks them. ``violations`` holds the campaign's measure, shape
    ``(n_evaluations, n_goals)``. ``costs`` holds the faults or fault-ticks of each if the campaign
    minimises them, else 0. ``distinct`` lists the first evaluation of each specification, whatever
    the order of its faults; ``tried`` counts each fault of the pool, by its ID, in these.
    """

    goals: tuple[str, ...]
    fitness: NDArray[np.float64]
    violations: NDArray[Any]
    costs: NDArray[np.int64]
    distinct: Rows
    tried: Counter[str]
    _keys: NDArray[np.uint64]

    @classmethod
    def read(cls, store: CampaignStore, measure: Measure, goals: Sequence[str] = ()) -> Self:
        """Read the evaluations of a campaign; ``goals`` are IDs that the record has."""
        measure.require(goals)
        n, n_read = store.n_evaluations, 0
        names, decoded = _decoding(measure, goals)
        kind = np.float64 if measure.n_seeds > 1 else np.int64  # means are not integers
        fitness, violations = np.empty(n), np.empty((n, len(goals)), kind)
        costs, keys = np.empty(n, np.int64), np.empty(n, np.uint64)
        is_first, earlier = np.zeros(n, bool), np.empty(0, np.uint64)
        tried: Counter[str] = Counter()
        for faults, texts, *numbers in store.stored(names, n, decoded):
            these = slice(n_read, n_read + len(faults))
            fitness[these], violations[these], costs[these] = numbers
            joined = ("]],[".join(sorted(each)).encode() for each in texts)
            hashes = (blake2b(each, digest_size=8).digest() for each in joined)
            keys[these] = np.frombuffer(b"".join(hashes), np.uint64)
            earlier, places = _merged(earlier, keys[these])
            for place in places:
                is_first[n_read + place] = True
                tried.update(faults[place])
            n_read = these.stop
        distinct = np.flatnonzero(is_first)
        return cls(tuple(goals), fitness, violations, costs, distinct, tried, keys)

    def __len__(self) -> int:
        return len(self.fitness)

    def of(self, goals: Sequence[str]) -> NDArray[Any]:
        """Return the violations of some goals, shape ``(n_evaluations, n_goals)``."""
        return self.violations[:, [self.goals.index(goal) for goal in goals]]

    def top(self, n: int) -> tuple[int, ...]:
        """Return the ``n`` most critical distinct evaluations, or all; of equals the first."""
        ranked = np.argsort(-self.fitness[self.distinct], kind="stable")
        return tuple(self.distinct[ranked[:n]].tolist())

    def distinct_among(self, rows: Sequence[int]) -> Rows:
        """Return the first evaluation of each specification among these."""
        found = np.unique(np.array(rows, np.intp))
        return found[np.sort(np.unique(self._keys[found], return_index=True)[1])]


def _decoding(
    measure: Measure, goals: Sequence[str]
) -> tuple[tuple[str, ...], Callable[[Sequence[Sequence[Any]]], tuple[Any, ...]]]:
    """Return the columns of a store to read, and a function that decodes rows of them."""
    is_mean = measure.n_seeds > 1
    recorded = measure.chosen if is_mean else measure.goals
    places = [recorded.index(goal) for goal in goals]
    counted = () if is_mean or not goals else (measure.kind,)

    def decoded(stored: Sequence[Sequence[Any]]) -> tuple[Any, ...]:
        """Return faults, texts of timed faults, fitness, violations and costs."""
        specifications, fitness_texts, fault_ticks, *counts = stored
        faults, texts = zip(*map(database.fault_texts, specifications), strict=True)
        fitness = database.lists(fitness_texts)
        violations: NDArray[Any] = np.empty((len(faults), 0))
        if places:
            found: Any = [each[1:] for each in fitness]
            if counts:
                found = database.integers(database.lists(counts[0]))
            table = np.array(found, np.float64 if is_mean else np.int64)
            violations = table.reshape(len(faults), len(recorded))[:, places]
        costs = [*map(len, faults)] if measure.minimised == "faults" else fault_ticks
        ranked_by = np.array([float(first) for first, *_ in fitness])
        return faults, texts, ranked_by, violations, costs if measure.minimised else 0

    return ("specification", "fitness", "fault_ticks", *counted), decoded


def _merged(
    earlier: NDArray[np.uint64], keys: NDArray[np.uint64]
) -> tuple[NDArray[np.uint64], list[int]]:
    """Return all keys so far, ascending, and the places of those that are new."""
    new, first = np.unique(keys, return_index=True)
    places = np.searchsorted(earlier, new)
    is_new = np.append(earlier, new[-1] + 1)[places] != new
    return np.insert(earlier, places[is_new], new[is_new]), sorted(first[is_new].tolist())


@dataclass(frozen=True, slots=True)
class FrontPoint:
    """A non-dominated specification: its evaluation, its violations, and how much it costs."""

    evaluation: int
    violations: tuple[float, ...]
    cost: int = 0


@dataclass(frozen=True, slots=True)
class Front:
    """The non-dominated points over chosen goals (IDs), each vector of violations once.

    The points stand in ascending order of violations of the first goal. ``counts`` names the kind
    of violations, ``minimised`` the cost that the front minimises, if any.
    """

    goals: tuple[str, ...]
    points: tuple[FrontPoint, ...]
    counts: str = "violations"
    minimised: str | None = None

    @property
    def aims(self) -> tuple[str, ...]:
        """Its objectives."""
        return self.goals if self.minimised is None else (*self.goals, self.minimised)


@dataclass(frozen=True, slots=True)
class Ratio:
    """A wanted ratio of violations of two goals (IDs): ``parts[0]`` to ``parts[1]``."""

    goals: tuple[str, str]
    parts: tuple[float, float]

    def __str__(self) -> str:
        return "{}:{}={:g}:{:g}".format(*self.goals, *self.parts)


def _undominated(vectors: NDArray[Any]) -> list[int]:
    """Return the places of undominated vectors; all are distinct and in ascending order."""
    # A dominating vector has no smaller sum; with an equal sum (by rounding) it stands later.
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
    """Return the front of evaluations; for equal vectors, the earliest evaluation is kept.

    ``rows`` are evaluations of distinct specifications, by default all of them.
    """
    rows = columns.distinct if rows is None else rows
    violations = columns.of(goals)[rows]
    costs = columns.costs[rows] if measure.minimised else np.zeros(len(rows), np.int64)
    vectors = np.column_stack([violations, -costs])
    earliest = _earliest(vectors)
    found = earliest[_undominated(vectors[earliest])]
    found_rows = zip(rows[found], violations[found], costs[found], strict=True)
    points = (FrontPoint(int(row), (*of.tolist(),), int(cost)) for row, of, cost in found_rows)
    return Front(tuple(goals), tuple(points), str(measure), measure.minimised)


def thinned(vectors: NDArray[Any]) -> tuple[list[tuple[float, ...]], int]:
    """Return the distinct vectors to be drawn, in ascending order, and how many are left out.

    Of more than ten thousand, only the smallest vector of each grid cell is drawn. A cell is a
    200th of the range of each goal, which is smaller than a drawn point.
    """
    shown = found = np.unique(vectors, axis=0)
    if len(found) > 10_000:
        least, most = found.min(axis=0), found.max(axis=0)
        cells = (found - least) * 200 // np.maximum(most - least, 1)
        shown = found[np.sort(_earliest(cells))]
    return [tuple(vector) for vector in shown.tolist()], len(found) - len(shown)


@dataclass(frozen=True, slots=True)
class Harm:
    """The most harm within a limit on faults or fault-ticks, and the evaluations that did it."""

    cost: int
    n_violated: int
    n_violated_by: int
    violations: float
    violations_by: int


def find_harm(measure: Measure, columns: Columns) -> tuple[Harm, ...]:
    """Return the front of harm against cost: an entry for each cost at which the harm grows.

    Of equally harmful specifications, the one of least cost counts, then the earliest. Only goals
    that the campaign chose count.
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
    """Return which values are greater than all values before; the first is."""
    return np.append(True, values[1:] > np.maximum.accumulate(values)[:-1])[: len(values)]


@dataclass(frozen=True, slots=True)
class Pick:
    """The point of a front over ``goals`` nearest to a ratio; ``None`` if none violates them."""

    ratio: Ratio
    point: FrontPoint | None
    goals: tuple[str, ...]

    @property
    def offered_in_words(self) -> str:
        """The ratio of the point."""
        if self.point is None:
            return ""
        first, second = (self.point.violations[self.goals.index(goal)] for goal in self.ratio.goals)
        return f", which is {first / second:.3g}:1" if second else f", which is {first:g}:0"

    def in_words(self, measure: Measure) -> str:
        """Return its evaluation and the violations of the ratio's goals as a phrase."""
        if self.point is None:
            return f"nearest to {self.ratio}: none, because no specification violates these goals"
        violations = dict(zip(self.goals, self.point.violations, strict=True))
        found = ", ".join(f"{goal} {ticks(violations[goal])}" for goal in self.ratio.goals)
        return (
            f"nearest to {self.ratio}: evaluation {self.point.evaluation} with {found} "
            f"({measure}){self.offered_in_words}"
        )


def parse_ratio(text: str) -> Ratio:
    """Parse a ratio such as ``g3:g1=2:1``; raise a ``UsageError`` for any other text."""
    goal, number = r"\s*([^:=\s]+)\s*", r"\s*(\d+(?:\.\d+)?)\s*"
    match = re.fullmatch(f"{goal}:{goal}={number}:{number}", text)
    if match is not None:
        parts = (float(match[3]), float(match[4]))
        if match[1] != match[2] and any(parts):
            return Ratio((match[1], match[2]), parts)
    raise UsageError(
        f"found ratio '{text}'; expected two goals and two numbers, not both 0, such as 'g3:g1=2:1'"
    )


def nearest_ratio(front: Front, ratio: Ratio) -> FrontPoint | None:
    """Return the point of the front nearest to a ratio (paper, section V, RQ3).

    The nearest point has the smallest angle between the violations of the two goals and the parts
    of the ratio, as vectors; of equal angles, the point with more violations counts. Points that
    violate neither goal have no ratio: ``None`` if all points are such.
    """
    first, second = (front.goals.index(goal) for goal in ratio.goals)
    direction = atan2(ratio.parts[1], ratio.parts[0])

    def distance(point: FrontPoint) -> tuple[float, float, int]:
        along, across = point.violations[first], point.violations[second]
        return abs(atan2(across, along) - direction), -(along + across), point.evaluation

    candidates = [p for p in front.points if p.violations[first] or p.violations[second]]
    return min(candidates, key=distance, default=None)
