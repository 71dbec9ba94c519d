"""The counts by which sets of faults are compared, each set flown once."""

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from typing import NamedTuple, TypeAlias

from mrsfi_runtime.errors import EvaluationError
from mrsfi_runtime.model.faults import Specification
from mrsfi_runtime.model.outcome import Evaluated, FailedFlight, Outcome
from mrsfi_runtime.record.measure import Measure

EvaluateIn: TypeAlias = Callable[[Sequence[Specification], int], Iterable[Evaluated]]
"""Evaluates fault specifications with a mission seed, as an ``Evaluator`` does."""


class Column(NamedTuple):
    """What is counted in ticks: violations of a goal, by its ID, as one of ``VIOLATIONS``."""

    goal: str
    kind: str


Counts: TypeAlias = tuple[int, ...]
"""Counts of one specification, shape ``(n_columns,)``, summed over the mission seeds."""


ALL_OR_NONE = "all faults, and none"
"""What flights are for until it is said."""


class Flights:
    """Flies fault specifications of a mission, each once, and counts violations.

    ``columns`` are for each goal first its violations in the measure, then the true ones; counts
    are over all ``mission_seeds``. ``n_flown`` has the number of flights until now, by what they
    were for.
    """

    def __init__(
        self,
        evaluate_many: EvaluateIn,
        measure: Measure,
        mission_seeds: tuple[int, ...],
    ) -> None:
        kinds = tuple(dict.fromkeys((measure.kind, "true")))
        self.mission_seeds = mission_seeds
        self.columns = tuple(Column(goal, kind) for goal in measure.chosen for kind in kinds)
        self.n_flown: Counter[str] = Counter()
        self._cells = [(measure.goals.index(goal), kind) for goal, kind in self.columns]
        self._evaluate_many = evaluate_many
        self._known: dict[tuple[Specification, int], Outcome] = {}
        self._purpose = ALL_OR_NONE

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

    def fly(self, specifications: Iterable[Specification], seed: int | None = None) -> None:
        """Fly what is not known yet, all at once, with one seed or all; a failure is an error."""
        wanted = tuple(dict.fromkeys(specifications))
        for one in self.mission_seeds if seed is None else (seed,):
            new = [each for each in wanted if (each, one) not in self._known]
            if not new:
                continue
            self.spend(len(new))
            for specification, outcome in zip(new, self._evaluate_many(new, one), strict=True):
                if isinstance(outcome, FailedFlight):
                    raise EvaluationError(_failure(specification, outcome))
                self._known[specification, one] = outcome

    def outcome(self, specification: Specification) -> Outcome:
        """Return what flying a specification finds in the first mission seed."""
        self.fly([specification])
        return self._known[specification, self.mission_seeds[0]]

    def counts(self, specification: Specification, seed: int | None = None) -> Counts:
        """Return the violations under a specification, shape ``(n_columns,)``, as ``fly``."""
        self.fly([specification], seed)
        seeds = self.mission_seeds if seed is None else (seed,)
        outcomes = [self._known[specification, one] for one in seeds]
        return tuple(
            sum(getattr(outcome, kind)[goal] for outcome in outcomes) for goal, kind in self._cells
        )


def _failure(specification: Specification, flight: FailedFlight) -> str:
    faults = ", ".join(f"{timed.fault} {timed.start} … {timed.finish}" for timed in specification)
    said = flight.traceback.strip().splitlines()[-1].partition(": ")[2]
    return f"{said} (flown with the faults {faults or 'of none'})"
