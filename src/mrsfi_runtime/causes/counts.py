"""The one prober of causes and weaknesses, and the counts by which sets of faults are compared."""

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from typing import Generic, NamedTuple, TypeAlias, TypeVar

from mrsfi_runtime.errors import EvaluationError
from mrsfi_runtime.model.faults import Specification
from mrsfi_runtime.model.mission import Evaluated, FailedFlight, Outcome
from mrsfi_runtime.record.store import Measure

EvaluateIn: TypeAlias = Callable[[Sequence[Specification], int], Iterable[Evaluated]]
"""Evaluates fault specifications with a mission seed, as an ``Evaluator`` does."""


class Column(NamedTuple):
    """What is counted in ticks: violations of a goal, by its ID, as one of ``VIOLATIONS``."""

    goal: str
    kind: str


Counts: TypeAlias = tuple[int, ...]
"""Counts of one specification, shape ``(n_columns,)``, summed over the mission seeds."""

Finding = TypeVar("Finding")

ALL_OR_NONE = "all faults, and none"
"""What flights are for until it is said."""


class Prober(Generic[Finding]):
    """Flies fault specifications, each once in a mission seed, and remembers what was found.

    ``known`` has what ``judge`` finds in each flight, by specification and mission seed; it may
    begin with some. ``n_flown`` has the number of flights until now, by what they were for.
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
        """Return what is found in flights with a mission seed; those not known fly all at once."""
        new = [each for each in dict.fromkeys(specifications) if (each, seed) not in self.known]
        if new:
            self.spend(len(new))
            for each, flown in zip(new, self._evaluate_many(new, seed), strict=True):
                self.known[each, seed] = self._judge(each, seed, flown)
        return [self.known[each, seed] for each in specifications]

    @contextmanager
    def on(self, purpose: str) -> Iterator[None]:
        """Count what is flown in the body as flown for a purpose."""
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

    ``columns`` are for each goal first its violations in the measure, then the true ones; counts
    are over all ``mission_seeds``. A flight that fails is an error.
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
        """Fly what is not known yet with all mission seeds, all at once with each."""
        wanted = tuple(specifications)
        for seed in self.mission_seeds:
            self(wanted, seed)

    def outcome(self, specification: Specification) -> Outcome:
        """Return what flying a specification finds in the first mission seed."""
        (found,) = self([specification], self.mission_seeds[0])
        return found

    def counts(self, specification: Specification, seed: int | None = None) -> Counts:
        """Return the violations under a specification, shape ``(n_columns,)``, with one or all."""
        seeds = self.mission_seeds if seed is None else (seed,)
        outcomes = [found for one in seeds for found in self([specification], one)]
        return tuple(
            sum(getattr(outcome, kind)[goal] for outcome in outcomes) for goal, kind in self._cells
        )


def _unfailed(specification: Specification, _seed: int, flown: Evaluated) -> Outcome:
    if not isinstance(flown, FailedFlight):
        return flown
    faults = ", ".join(f"{timed.fault} {timed.start} … {timed.finish}" for timed in specification)
    said = flown.traceback.strip().splitlines()[-1].partition(": ")[2]
    raise EvaluationError(f"{said} (flown with the faults {faults or 'of none'})")
