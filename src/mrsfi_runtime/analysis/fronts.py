"""Which evaluations are the most critical; Pareto fronts, and the pick by a ratio.

References
----------
Source paper, section III-A, step 6, section III-D, equation (3), and section V, RQ3.
"""

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
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
    """A non-dominated specification: its evaluation and its violations of the chosen goals.

    ``cost`` is how much it has of what the front has few of; 0 if of nothing.
    """

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
    earliest: dict[tuple[float, ...], FrontPoint] = {}
    for evaluation in sorted(distinct(evaluations), key=lambda each: each.index):
        violations, cost = measure.violations(evaluation, goals), measure.cost(evaluation)
        point = FrontPoint(evaluation.index, violations, cost)
        earliest.setdefault((*violations, -cost), point)
    points = tuple(earliest[vector] for vector in non_dominated(earliest))
    return Front(tuple(goals), points, str(measure), measure.minimised)


@dataclass(frozen=True, slots=True)
class Harm:
    """The most harm that so few faults, or ticks of faults, were found to do.

    Attributes
    ----------
    cost
        How many faults, or ticks of faults, a specification has at most.
    n_violated
        Most goals that one of these specifications violates, and ``n_violated_by`` its evaluation.
    violations
        Most violations of all looked at goals together, and ``violations_by`` their evaluation.
    """

    cost: int
    n_violated: int
    n_violated_by: int
    violations: float
    violations_by: int


def find_harm(measure: Measure, evaluations: Iterable[Evaluation]) -> tuple[Harm, ...]:
    """Return the front of harm against cost: an entry for each cost from which on there is more.

    Of equally harmful specifications the one of least cost counts, then the earliest. Looked at
    are the goals that the campaign chose.
    """
    found: dict[int, Harm] = {}
    harm: Harm | None = None
    for evaluation in sorted(evaluations, key=lambda each: (measure.cost(each), each.index)):
        counts = measure.violations(evaluation, measure.chosen)
        cost, index = measure.cost(evaluation), evaluation.index
        new = Harm(cost, sum(count > 0 for count in counts), index, sum(counts), index)
        if harm is None or new.n_violated > harm.n_violated or new.violations > harm.violations:
            harm = found[cost] = new if harm is None else _more(new, harm)
    return tuple(found.values())


def _more(new: Harm, known: Harm) -> Harm:
    """Return the later harm, with what the one before it did more of, or as much."""
    if known.n_violated >= new.n_violated:
        new = replace(new, n_violated=known.n_violated, n_violated_by=known.n_violated_by)
    if known.violations >= new.violations:
        new = replace(new, violations=known.violations, violations_by=known.violations_by)
    return new


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
