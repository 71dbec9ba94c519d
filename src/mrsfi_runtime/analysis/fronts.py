"""Which evaluations are the most critical; Pareto fronts, and the pick by a ratio.

References
----------
Source paper, section III-A, step 6, section III-D, equation (3), and section V, RQ3.
"""

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from math import atan2

import numpy as np

from mrsfi_runtime.errors import UsageError
from mrsfi_runtime.record.campaign import Evaluation
from mrsfi_runtime.record.measure import Measure

_NUMBER = r"(\d+(?:\.\d+)?)"
_RATIO = re.compile(rf"\s*([^:=\s]+)\s*:\s*([^:=\s]+)\s*=\s*{_NUMBER}\s*:\s*{_NUMBER}\s*")


def score(evaluation: Evaluation) -> float:
    """Return the number to rank by."""
    return evaluation.fitness[0]


def distinct(evaluations: Iterable[Evaluation]) -> tuple[Evaluation, ...]:
    """Return the first of every specification, whose faults may stand in any order, as given."""
    first: dict[object, Evaluation] = {}
    for evaluation in evaluations:
        first.setdefault(tuple(sorted(evaluation.specification)), evaluation)
    return tuple(first.values())


def top(evaluations: Iterable[Evaluation], n: int) -> tuple[Evaluation, ...]:
    """Return the ``n`` most critical distinct evaluations, or all if there are fewer.

    Of two with the same fitness the earlier one comes first.
    """
    ranked = sorted(
        distinct(evaluations), key=lambda evaluation: (-score(evaluation), evaluation.index)
    )
    return tuple(ranked[:n])


@dataclass(frozen=True, slots=True)
class FrontPoint:
    """A non-dominated specification: its evaluation and its violations of the chosen goals."""

    evaluation: int
    violations: tuple[float, ...]


@dataclass(frozen=True, slots=True)
class Front:
    """The non-dominated points over chosen goals (IDs), each vector of violations once.

    The points run from few violations of the first goal to many; ``counts`` says which
    violations they are.
    """

    goals: tuple[str, ...]
    points: tuple[FrontPoint, ...]
    counts: str = "violations"


@dataclass(frozen=True, slots=True)
class Ratio:
    """The wish that violations of two goals (IDs) stand as ``parts[0]`` to ``parts[1]``."""

    goals: tuple[str, str]
    parts: tuple[float, float]

    def __str__(self) -> str:
        return "{}:{}={:g}:{:g}".format(*self.goals, *self.parts)


def non_dominated(vectors: Iterable[tuple[float, ...]]) -> tuple[tuple[float, ...], ...]:
    """Return the distinct vectors that no other dominates, in ascending order; more is better."""
    members: list[tuple[float, ...]] = []
    # A vector can only be dominated by one that comes later in ascending order, and then also
    # by one of the front so far, because domination is transitive.
    for vector in sorted(set(vectors), reverse=True):
        if not members or not (np.array(members) >= vector).all(axis=1).any():
            members.append(vector)
    return tuple(reversed(members))


def find_front(measure: Measure, evaluations: Iterable[Evaluation], goals: Sequence[str]) -> Front:
    """Return the front of some evaluations; of equal vectors the earliest evaluation stands.

    Raises
    ------
    UsageError
        If the record lacks the violations of one of the goals.
    """
    measure.require(goals)
    earliest: dict[tuple[float, ...], int] = {}
    for evaluation in distinct(evaluations):
        vector = measure.violations(evaluation, goals)
        earliest[vector] = min(evaluation.index, earliest.get(vector, evaluation.index))
    points = tuple(FrontPoint(earliest[vector], vector) for vector in non_dominated(earliest))
    return Front(tuple(goals), points, str(measure))


@dataclass(frozen=True, slots=True)
class Pick:
    """The point of a front that comes nearest to a wanted ratio.

    Attributes
    ----------
    point
        ``None`` if no specification violates a goal of the ratio.
    goals
        Goals of the front, in the order of the point's violations.
    """

    ratio: Ratio
    point: FrontPoint | None
    goals: tuple[str, ...]


def parse_ratio(text: str) -> Ratio:
    """Return the ratio that ``g3:g1=2:1`` asks for.

    Raises
    ------
    UsageError
        If the text says something else.
    """
    match = _RATIO.fullmatch(text)
    if match is not None:
        first, second = match[1], match[2]
        parts = (float(match[3]), float(match[4]))
        if first != second and any(parts):
            return Ratio((first, second), parts)
    raise UsageError(
        f"found ratio '{text}'; expected two goals and two numbers, not both 0, such as 'g3:g1=2:1'"
    )


def nearest_ratio(front: Front, wanted: str | Ratio) -> FrontPoint | None:
    """Return the point of the front whose violations come nearest to a ratio.

    Nearest is the smallest angle between the two goals' violations and the two parts of the
    ratio, as vectors; of equal angles the point with more violations of the two goals.
    Points that violate neither goal have no ratio.

    Returns
    -------
    FrontPoint or None
        ``None`` if no point violates either goal.

    Raises
    ------
    UsageError
        If the ratio makes no sense or the front is not over its goals.

    References
    ----------
    Source paper, section V, RQ3.
    """
    ratio = parse_ratio(wanted) if isinstance(wanted, str) else wanted
    if not set(ratio.goals) <= set(front.goals):
        chosen = ", ".join(front.goals) or "none"
        raise UsageError(f"found ratio '{ratio}'; expected two of the front's goals: {chosen}")
    first, second = (front.goals.index(goal) for goal in ratio.goals)
    direction = atan2(ratio.parts[1], ratio.parts[0])

    def distance(point: FrontPoint) -> tuple[float, float, int]:
        along, across = point.violations[first], point.violations[second]
        return abs(atan2(across, along) - direction), -(along + across), point.evaluation

    candidates = [p for p in front.points if p.violations[first] or p.violations[second]]
    return min(candidates, key=distance, default=None)
