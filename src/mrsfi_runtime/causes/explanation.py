"""All that is found out about one specification, in the order in which it is asked."""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import partial

from mrsfi_runtime.causes.attribution import Attribution, attribute
from mrsfi_runtime.causes.cause_set import Places, Question, chosen, floor, without
from mrsfi_runtime.causes.chain import Chain, chains
from mrsfi_runtime.causes.counts import Column, Counts, Flights
from mrsfi_runtime.causes.firmness import N_SEEDS, Firmness, firmness
from mrsfi_runtime.causes.labels import GoalCauses, goal_causes
from mrsfi_runtime.causes.simplest import simplest
from mrsfi_runtime.engine.flights import Engine
from mrsfi_runtime.hosting.lockstep import Observer
from mrsfi_runtime.model.faults import Specification
from mrsfi_runtime.model.outcome import Outcome
from mrsfi_runtime.record.settings import following


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
    outcome
        What flying the cause set finds in the first mission seed.
    simplest, simplest_counts
        Its simplest form, and the counts under that.
    minima
        The different cause sets that shuffled orders gave, this one among them or not.
    goals
        What each goal's own violations are due to.
    alone, left_out
        Counts under each fault alone, and under all but it.
    attribution
        How much of each count is due to each fault of the cause set.
    chains
        What each fault of the cause set changes first, against the cause set without it, in the
        first mission seed.
    firmness
        What each count under the cause set is in ``N_SEEDS`` mission seeds, the first one on.
    n_flown
        How many specifications were flown for each part of this.
    """

    specification: Specification
    columns: tuple[Column, ...]
    counts: Counts
    fault_free: Counts
    kept: Counts
    cause_set: Places
    outcome: Outcome
    simplest: Specification
    simplest_counts: Counts
    minima: tuple[Places, ...]
    goals: tuple[GoalCauses, ...]
    alone: tuple[Counts, ...]
    left_out: tuple[Counts, ...]
    attribution: Attribution
    chains: tuple[Chain, ...]
    firmness: tuple[Firmness, ...]
    n_flown: Mapping[str, int]

    @property
    def cause(self) -> Specification:
        """The cause set as a specification."""
        return chosen(self.specification, self.cause_set)


def explain(
    flights: Flights, engine: Engine, specification: Specification, keep: float
) -> Explanation | None:
    """Find out why a specification breaks goals.

    Parameters
    ----------
    flights
        Flies its faults.
    engine
        Flies what has to be looked at, or to be in other weather; its seed is the first.
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
        left_out = tuple(without(specification, place) for place in range(n))
        flights.fly((*alone, *left_out))
    with spent.on("cause set and labels of each goal"):
        goals = tuple(
            goal_causes(Question(flights, specification, floor(counts, keep, places)), goal)
            for goal, places in _by_goal(columns).items()
        )
    with spent.on("attribution"):
        attribution = attribute(flights, cause)
    with spent.on("simplest form"):
        simple = simplest(flights, engine.code.mission, engine.code.pool, cause)
    observe = partial(_observe, engine)
    linked = chains(observe, engine.code.mission, cause) if cause else ()
    firm = _firmness(flights, engine, cause)
    return Explanation(
        specification=specification,
        columns=columns,
        counts=counts,
        fault_free=fault_free,
        kept=flights.counts(cause),
        cause_set=cause_set,
        outcome=flights.outcomes(cause)[0],
        simplest=simple,
        simplest_counts=flights.counts(simple),
        minima=minima,
        goals=goals,
        alone=tuple(map(flights.counts, alone)),
        left_out=tuple(map(flights.counts, left_out)),
        attribution=attribution,
        chains=linked,
        firmness=firm,
        n_flown=spent.n_flown
        | {"chains": len(linked) + 1 if linked else 0, "other mission seeds": N_SEEDS},
    )


def _observe(engine: Engine, specification: Specification, observer: Observer) -> None:
    engine.evaluate(specification, observer=observer)


def _firmness(
    flights: Flights, engine: Engine, specification: Specification
) -> tuple[Firmness, ...]:
    """Return what the counts of a specification are in other weather."""
    measure = replace(flights.measure, n_seeds=1)
    return firmness(
        [
            Flights([partial(engine.evaluate_many, seed=seed)], measure).counts(specification)
            for seed in following(engine.seed, N_SEEDS)
        ]
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
