"""The counts by which sets of faults are compared, each set flown once."""

from collections.abc import Iterable, Sequence
from typing import NamedTuple, TypeAlias

from mrsfi_runtime.engine.flights import FailedFlight
from mrsfi_runtime.errors import EvaluationError
from mrsfi_runtime.model.faults import Specification
from mrsfi_runtime.model.outcome import Outcome
from mrsfi_runtime.record.measure import Measure
from mrsfi_runtime.search.resumable_record import EvaluateMany


class Column(NamedTuple):
    """What is counted in ticks: violations of a goal, by its ID, as one of ``VIOLATIONS``."""

    goal: str
    kind: str


Counts: TypeAlias = tuple[int, ...]
"""Counts of one specification, shape ``(n_columns,)``, summed over the mission seeds."""


class Flights:
    """Flies fault specifications of a mission, each once, and counts violations.

    Parameters
    ----------
    evaluators
        One for each mission seed.
    measure
        Names the goals that are counted, and the violations, beside the true ones.

    Attributes
    ----------
    measure
        See above.
    columns
        What is counted: for each goal first its violations in the measure, then the true ones.
    n_flown
        Number of specifications that were flown until now, in all mission seeds each.
    """

    def __init__(self, evaluators: Sequence[EvaluateMany], measure: Measure) -> None:
        kinds = tuple(dict.fromkeys((measure.kind, "true")))
        self.measure = measure
        self.columns = tuple(Column(goal, kind) for goal in measure.chosen for kind in kinds)
        self._cells = [(measure.goals.index(goal), kind) for goal, kind in self.columns]
        self._evaluators = evaluators
        self._known: dict[Specification, tuple[Outcome, ...]] = {}

    @property
    def n_flown(self) -> int:
        """See the class."""
        return len(self._known)

    def fly(self, specifications: Iterable[Specification]) -> None:
        """Fly specifications all at once, as far as they are not known.

        Raises
        ------
        EvaluationError
            If the mission's own code fails in one of them.
        """
        new = [each for each in dict.fromkeys(specifications) if each not in self._known]
        if not new:
            return
        by_seed = [list(evaluate_many(new)) for evaluate_many in self._evaluators]
        for specification, *found in zip(new, *by_seed, strict=True):
            outcomes = []
            for outcome in found:
                if isinstance(outcome, FailedFlight):
                    raise EvaluationError(_failure(specification, outcome))
                outcomes.append(outcome)
            self._known[specification] = tuple(outcomes)

    def outcomes(self, specification: Specification) -> tuple[Outcome, ...]:
        """Return what flying a specification finds in each mission seed."""
        self.fly([specification])
        return self._known[specification]

    def counts(self, specification: Specification) -> Counts:
        """Return the violations under a specification, shape ``(n_columns,)``."""
        outcomes = self.outcomes(specification)
        return tuple(
            sum(getattr(outcome, kind)[goal] for outcome in outcomes) for goal, kind in self._cells
        )


def _failure(specification: Specification, flight: FailedFlight) -> str:
    faults = ", ".join(f"{timed.fault} {timed.start} … {timed.finish}" for timed in specification)
    said = flight.traceback.strip().splitlines()[-1].partition(": ")[2]
    return f"{said} (flown with the faults {faults or 'of none'})"
