"""All that is found out about one specification, in the order in which it is asked."""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass

from mrsfi_runtime.causes.attribution import Attribution, attribute
from mrsfi_runtime.causes.cause_set import Places, Question, chosen, floor
from mrsfi_runtime.causes.counts import Column, Counts, Flights
from mrsfi_runtime.causes.labels import GoalCauses, goal_causes
from mrsfi_runtime.model.faults import Specification


@dataclass(frozen=True, slots=True)
class Explanation:
    """Why a specification breaks goals.

    Attributes
    ----------
    specification
        All its faults.
    columns
        What is counted.
    counts, fault_free, kept
        Counts under all faults, under none, and under the cause set.
    cause_set
        The faults without which the violations would not be.
    n_minima
        How many different cause sets shuffled orders gave, this one among them or not.
    goals
        What each goal's own violations are due to.
    alone, left_out
        Counts under each fault alone, and under all but it.
    attribution
        How much of each count is due to each fault of the cause set.
    n_flown
        How many specifications were flown for each part of this.
    """

    specification: Specification
    columns: tuple[Column, ...]
    counts: Counts
    fault_free: Counts
    kept: Counts
    cause_set: Places
    n_minima: int
    goals: tuple[GoalCauses, ...]
    alone: tuple[Counts, ...]
    left_out: tuple[Counts, ...]
    attribution: Attribution
    n_flown: Mapping[str, int]

    @property
    def cause(self) -> Specification:
        """The cause set as a specification."""
        return chosen(self.specification, self.cause_set)


def explain(flights: Flights, specification: Specification, keep: float) -> Explanation | None:
    """Find out why a specification breaks goals.

    Parameters
    ----------
    flights
        Flies its faults.
    specification
        All its faults.
    keep
        Share of every count that a cause set keeps, above 0, at most 1.

    Returns
    -------
    Explanation or None
        ``None`` if it violates nothing that is counted.

    Raises
    ------
    EvaluationError
        If the mission's own code fails.
    """
    spent = _Spent(flights)
    n, columns = len(specification), flights.columns
    with spent.on("all faults, and none"):
        counts, fault_free = flights.counts(specification), flights.counts(())
    if not any(counts):
        return None
    question = Question(flights, specification, floor(counts, keep, range(len(columns))))
    with spent.on("cause set"):
        cause_set = question.minimum()
    cause = chosen(specification, cause_set)
    with spent.on("other orders"):
        minima = question.minima()
    with spent.on("each fault alone, and left out"):
        alone = tuple((fault,) for fault in specification)
        left_out = tuple((*specification[:k], *specification[k + 1 :]) for k in range(n))
        flights.fly((*alone, *left_out))
    with spent.on("cause set and labels of each goal"):
        goals = tuple(
            goal_causes(Question(flights, specification, floor(counts, keep, places)), goal)
            for goal, places in _by_goal(columns).items()
        )
    with spent.on("attribution"):
        attribution = attribute(flights, cause)
    return Explanation(
        specification=specification,
        columns=columns,
        counts=counts,
        fault_free=fault_free,
        kept=flights.counts(cause),
        cause_set=cause_set,
        n_minima=len(minima),
        goals=goals,
        alone=tuple(map(flights.counts, alone)),
        left_out=tuple(map(flights.counts, left_out)),
        attribution=attribution,
        n_flown=spent.n_flown,
    )


def _by_goal(columns: tuple[Column, ...]) -> dict[str, list[int]]:
    places: dict[str, list[int]] = {}
    for place, column in enumerate(columns):
        places.setdefault(column.goal, []).append(place)
    return places


class _Spent:
    """Notes how many specifications are flown for each part of an explanation, and before it."""

    def __init__(self, flights: Flights) -> None:
        self._flights = flights
        self.n_flown: dict[str, int] = {}

    @contextmanager
    def on(self, part: str) -> Iterator[None]:
        """Note what is flown in the body."""
        yield
        self.n_flown[part] = self._flights.n_flown - sum(self.n_flown.values())
