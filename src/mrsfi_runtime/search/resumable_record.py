"""What a campaign has found so far: read back when it is resumed, and extended by what is new."""

from collections.abc import Callable, Iterable, Sequence
from math import inf
from typing import TypeAlias

from mrsfi_runtime.errors import RecordError
from mrsfi_runtime.model.faults import Specification
from mrsfi_runtime.model.outcome import Evaluated
from mrsfi_runtime.record.store import CampaignStore, Evaluation, FailedEvaluation, Generation

WORST_FITNESS = 0.0
"""Fitness of a specification whose evaluation failed; that of one without a violation."""

_PATIENCE = 20  # a write comes no sooner than so many times as long as the last one took
_MOST_WAITING = 1000  # results that wait for it: of more, a write takes no smaller share of time

Result: TypeAlias = Evaluation | FailedEvaluation
"""What became of one specification that the search asked for."""


EvaluateMany: TypeAlias = Callable[[Sequence[Specification]], Iterable[Evaluated]]
"""Evaluates fault specifications; one result each, in the same order, best as soon as known."""


class ResumableRecord:
    """The record of a campaign in the order in which its search asked."""

    def __init__(self, store: CampaignStore, source: str, clock: Callable[[], float]) -> None:
        self._store = store
        self._source = source
        self._clock = clock
        self._due = -inf  # when the next write may come
        self._pending: list[Result | Generation] = []
        self._failures = {failure.number: failure for failure in store.failures()}
        self._n_recorded = store.n_evaluations + len(self._failures)

    def recorded(
        self, number: int, index: int, specifications: Sequence[Specification], generation: int
    ) -> list[Result]:
        """Return what a record from before has of specifications: all, the first ones or none.

        So many were asked for before these, and so many of those evaluated without failure.
        """
        n_known = max(0, min(len(specifications), self._n_recorded - number))
        evaluations = iter(self._store.evaluations(index, n_known) if n_known else ())
        results: list[Result] = []
        for place, asked in enumerate(specifications[:n_known], number):
            result = self._failures.get(place) or next(evaluations, None)
            if result is None or (result.specification, result.generation) != (asked, generation):
                raise RecordError(self.astray(f"specification {place} of the search"))
            results.append(result)
        return results

    def has(self, generation: Generation) -> bool:
        """Return whether a generation is recorded; refuse another one in its place."""
        recorded = self._store.generation(generation.index)
        if recorded is not None and recorded != generation:
            raise RecordError(self.astray(f"generation {generation.index}"))
        return recorded is not None

    def astray(self, place: str) -> str:
        """Return the message for a record of which a place is not what the search makes."""
        return (
            f"{self._source}: the record does not follow from its own settings, models and code: "
            f"{place} is another one; expected what the same mrsfi, Python and DEAP would search; "
            "resume with the versions it was begun with (manifest in campaign.sqlite), or begin "
            "a new campaign"
        )

    def keep(self, result: Result | Generation) -> None:
        """Write a new result or a finished generation, at once or with later ones.

        At once, unless writing would then take more than a small share of the time; those that
        wait, a thousand at most, are lost if the process is killed.
        """
        self._pending.append(result)
        begin = self._clock()
        if begin >= self._due or len(self._pending) >= _MOST_WAITING:
            self.write()
            end = self._clock()
            self._due = end + _PATIENCE * (end - begin)

    def write(self) -> None:
        """Write what waits, but for what was written when an interrupt kept it waiting."""
        if self._pending:
            kept = self._pending
            evaluation, failure, generation = self._store.next_indexes()
            self._store.append(
                [e for e in kept if isinstance(e, Evaluation) and e.index >= evaluation],
                [e for e in kept if isinstance(e, FailedEvaluation) and e.number >= failure],
                [e for e in kept if isinstance(e, Generation) and e.index >= generation],
            )
            kept.clear()
