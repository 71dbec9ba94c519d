"""Find the faults of a specification without which its violations would not occur.

A set of faults is *sufficient* if it alone keeps a stated share of every count. The cause set is
1-minimal: without any one of its faults it is not sufficient. A ``Prober`` remembers its flights,
so no specification is flown twice in a mission seed.

Begin with ``Prober`` and ``Flights``, which fly and count. A ``Question`` asks which faults are
needed; ``reduction`` is its algorithm.

References
----------
A. Zeller and R. Hildebrandt, "Simplifying and Isolating Failure-Inducing Input", IEEE Transactions
on Software Engineering 28(2), 2002: the algorithm ddmin, and 1-minimality. R. Hodován and Á. Kiss,
"Practical Improvements to the Minimizing Delta Debugging Algorithm", ICSOFT 2016: testing only
complements of parts takes fewer trials, and the result stays 1-minimal.
"""

import math
from collections import Counter
from collections.abc import Callable, Generator, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from fractions import Fraction
from random import Random
from typing import Generic, NamedTuple, TypeAlias, TypeVar

from mrsfi_runtime.errors import EvaluationError
from mrsfi_runtime.model.faults import Specification
from mrsfi_runtime.model.mission import Evaluated, FailedFlight, Outcome
from mrsfi_runtime.record.store import Measure

EvaluateIn: TypeAlias = Callable[[Sequence[Specification], int], Iterable[Evaluated]]
"""Evaluates fault specifications with a mission seed, as an ``Evaluator`` does."""


class Column(NamedTuple):
    """A count in ticks: violations of a goal, by its ID, of one of the ``VIOLATIONS``."""

    goal: str
    kind: str


Counts: TypeAlias = tuple[int, ...]
"""Counts of one specification, shape ``(n_columns,)``, summed over the mission seeds."""

Finding = TypeVar("Finding")

ALL_OR_NONE = "all faults, and none"
"""Purpose of flights if no other is given."""


class Prober(Generic[Finding]):
    """Flies fault specifications, each once in a mission seed, and remembers the findings.

    ``known`` has what ``judge`` returns for each flight, by specification and mission seed; it may
    be filled in advance. ``n_flown`` counts flights by their purpose.
    """

    def __init__(
        self, evaluate_many: EvaluateIn, judge: Callable[[Specification, int, Evaluated], Finding]
    ) -> None:
        self.known: dict[tuple[Specification, int], Finding] = {}
        self.n_flown: Counter[str] = Counter()
        self._evaluate_many = evaluate_many
        self._judge = judge
        self._purpose = ALL_OR_NONE

    def __call__(self, specifications: Sequence[Specification], seed: int) -> list[Finding]:
        """Return the findings of flights with a mission seed; new ones are flown in one batch."""
        new = [each for each in dict.fromkeys(specifications) if (each, seed) not in self.known]
        if new:
            self.spend(len(new))
            for each, flown in zip(new, self._evaluate_many(new, seed), strict=True):
                self.known[each, seed] = self._judge(each, seed, flown)
        return [self.known[each, seed] for each in specifications]

    @contextmanager
    def on(self, purpose: str) -> Iterator[None]:
        """Count the flights of the body under a purpose."""
        before, self._purpose = self._purpose, purpose
        try:
            yield
        finally:
            self._purpose = before

    def spend(self, n_flights: int) -> None:
        """Count flights that are about to begin."""
        self.n_flown[self._purpose] += n_flights


class Flights(Prober[Outcome]):
    """Counts the violations of a mission's goals under fault specifications.

    ``columns`` has for each goal its violations in the measure, then the true ones. Counts are sums
    over all ``mission_seeds``. A flight that fails is an error.
    """

    def __init__(
        self, evaluate_many: EvaluateIn, measure: Measure, mission_seeds: tuple[int, ...]
    ) -> None:
        super().__init__(evaluate_many, _unfailed)
        kinds = tuple(dict.fromkeys((measure.kind, "true")))
        self.mission_seeds = mission_seeds
        self.columns = tuple(Column(goal, kind) for goal in measure.chosen for kind in kinds)
        self._cells = [(measure.goals.index(goal), kind) for goal, kind in self.columns]

    def fly(self, specifications: Iterable[Specification]) -> None:
        """Fly new specifications with all mission seeds, in one batch for each."""
        wanted = tuple(specifications)
        for seed in self.mission_seeds:
            self(wanted, seed)

    def outcome(self, specification: Specification) -> Outcome:
        """Return the outcome of a specification in the first mission seed."""
        return self([specification], self.mission_seeds[0])[0]

    def counts(self, specification: Specification, seed: int | None = None) -> Counts:
        """Return the violations under a specification, shape ``(n_columns,)``, in a seed or all."""
        seeds = self.mission_seeds if seed is None else (seed,)
        outcomes = [found for one in seeds for found in self([specification], one)]
        return tuple(
            sum(getattr(outcome, kind)[goal] for outcome in outcomes) for goal, kind in self._cells
        )


def _unfailed(specification: Specification, _seed: int, flown: Evaluated) -> Outcome:
    if not isinstance(flown, FailedFlight):
        return flown
    faults = ", ".join(f"{timed.fault} {timed.start} … {timed.finish}" for timed in specification)
    message = flown.traceback.strip().splitlines()[-1].partition(": ")[2]
    raise EvaluationError(f"{message} (flown with the faults {faults or 'of none'})")


N_ORDERS = 5
"""Shuffled orders in which other minima are searched."""

Places: TypeAlias = tuple[int, ...]
"""Faults of a specification, by their places in it, ascending."""

Floor: TypeAlias = Mapping[int, int]
"""The lowest count that has to remain, by column."""


def floor(counts: Counts, keep: float, columns: Iterable[int]) -> Floor:
    """Return the counts that a sufficient set of faults keeps; columns at 0 require nothing."""
    share = Fraction(str(keep))  # exact: 0.95 of 20 is 19, not slightly more
    return {k: math.ceil(share * counts[k]) for k in columns if counts[k]}


@dataclass(frozen=True, slots=True)
class Question:
    """Which faults of a specification are needed to keep its counts above a floor."""

    flights: Flights
    specification: Specification
    floor: Floor

    def is_kept_by(self, places: Iterable[int]) -> bool:
        """Return whether these faults alone are sufficient."""
        counts = self.flights.counts(chosen(self.specification, places))
        return all(counts[k] >= least for k, least in self.floor.items())

    def minimum(self, order: Iterable[int] | None = None) -> Places:
        """Return a 1-minimal set: without any one of its faults, some count is too low.

        Faults are left out in the order of the specification, or in another, which may lead to
        another set.
        """
        places = range(len(self.specification)) if order is None else order
        trials = reduction(tuple(places))
        trial = next(trials)
        while True:
            try:
                trial = trials.send(self.is_kept_by(trial))
            except StopIteration as end:
                return tuple(sorted(end.value))

    def minima(self) -> tuple[Places, ...]:
        """Return the different minima that ``N_ORDERS`` shuffled orders lead to."""
        random = Random(1)
        places = range(len(self.specification))
        orders = [random.sample(places, len(places)) for _ in range(N_ORDERS)]
        return tuple(dict.fromkeys(self.minimum(order) for order in orders))


def chosen(specification: Specification, places: Iterable[int]) -> Specification:
    """Return some faults of a specification, in its order."""
    return tuple(specification[place] for place in sorted(places))


def without(specification: Specification, place: int) -> Specification:
    """Return all faults of a specification but one."""
    return (*specification[:place], *specification[place + 1 :])


def reduction(order: tuple[int, ...]) -> Generator[tuple[int, ...], bool, tuple[int, ...]]:
    """Yield parts of an order, receive whether each is sufficient, and return a 1-minimal one.

    First halves are left out, at last single faults, until no single one can be. Trials go from
    back to front, so that of equivalent faults the earlier ones stay.
    """
    if (yield ()):
        return ()
    left, size = order, (len(order) + 1) // 2
    while True:
        n_before = len(left)
        for last in range(n_before, 0, -size):
            rest = (*left[: max(0, last - size)], *left[last:])
            if (yield rest):
                left = rest
        if size == 1 and len(left) == n_before:
            return left
        size = max(1, size // 2)
