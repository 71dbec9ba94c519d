"""What a report asks of all evaluations, in arrays: tens of bytes for each, and no object.

A specification is told by eight bytes of a hash over its timed faults, in whatever order they
stand. In a campaign of a million evaluations two different ones have the same with a chance of
three in a hundred million; one of them would then not be counted as distinct.
"""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from hashlib import blake2b
from typing import Any, Self, TypeAlias

import numpy as np
from numpy.typing import NDArray

from mrsfi_runtime.record import encoding
from mrsfi_runtime.record.measure import Measure
from mrsfi_runtime.record.store import CampaignStore, Evaluation

Rows: TypeAlias = NDArray[np.intp]
"""Indexes of evaluations, ascending."""


@dataclass(frozen=True, slots=True)
class Columns:
    """The evaluations of a campaign, each of which has a row.

    ``fitness`` is what they are ranked by, ``violations`` the campaign's own measure, shape
    ``(n_evaluations, n_goals)``; ``costs`` say how much each has of what is minimised, 0 if nothing
    is. ``distinct`` has the first of every specification, whose faults may stand in any order, and
    ``tried`` how often each fault of the pool, by its ID, stands in these.
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
        """Read the evaluations of a campaign, some thousand at a time, for goals by their IDs.

        A goal whose violations the record lacks is a ``UsageError``.
        """
        measure.require(goals)
        reading = _Reading(measure, goals, store.n_evaluations)
        for stored in store.stored(reading.columns, len(reading.fitness), reading.decoded):
            reading.take(*stored)
        return cls(
            goals=tuple(goals),
            fitness=reading.fitness,
            violations=reading.violations,
            costs=reading.costs,
            distinct=np.flatnonzero(reading.is_first),
            tried=reading.tried,
            _keys=reading.keys,
        )

    def __len__(self) -> int:
        return len(self.fitness)

    def of(self, goals: Sequence[str]) -> NDArray[Any]:
        """Return the violations of some goals, shape ``(n_evaluations, n_goals)``."""
        return self.violations[:, [self.goals.index(goal) for goal in goals]]

    def top(self, n: int) -> tuple[int, ...]:
        """Return the ``n`` most critical distinct evaluations, or all if there are fewer.

        Of two with the same fitness the earlier one comes first.
        """
        ranked = np.argsort(-self.fitness[self.distinct], kind="stable")
        return tuple(self.distinct[ranked[:n]].tolist())

    def distinct_among(self, rows: Sequence[int]) -> Rows:
        """Return the first of every specification among some evaluations."""
        found = np.unique(np.array(rows, np.intp))
        return found[np.sort(np.unique(self._keys[found], return_index=True)[1])]


def top(store: CampaignStore, measure: Measure, n: int) -> tuple[Evaluation, ...]:
    """Return the ``n`` most critical distinct evaluations of a campaign, or all if it has fewer."""
    return tuple(store.evaluation(index) for index in Columns.read(store, measure).top(n))


class _Reading:
    """Fills arrays with what a campaign has stored."""

    def __init__(self, measure: Measure, goals: Sequence[str], n: int) -> None:
        self._is_mean = measure.n_seeds > 1
        self._recorded = measure.chosen if self._is_mean else measure.goals
        self._places = [self._recorded.index(goal) for goal in goals]
        self._minimised = measure.minimised
        counted = () if self._is_mean or not goals else (measure.kind,)
        self.columns = ("specification", "fitness", "fault_ticks", *counted)
        self.fitness = np.empty(n)
        self.violations = np.empty((n, len(goals)), np.float64 if self._is_mean else np.int64)
        self.costs = np.zeros(n, np.int64)
        self.keys = np.empty(n, np.uint64)
        self.is_first = np.zeros(n, bool)
        self.tried: Counter[str] = Counter()
        self._known = np.empty(0, np.uint64)  # all keys so far, ascending
        self._n_read = 0

    def decoded(self, stored: Sequence[Sequence[Any]]) -> tuple[Any, ...]:
        """Return faults, texts of timed faults, fitness, violations and costs of some rows."""
        specifications, fitness_texts, fault_ticks, *counts = stored
        faults, texts = zip(*map(encoding.fault_texts, specifications), strict=True)
        fitness = encoding.lists(fitness_texts)
        violations: NDArray[Any] = np.empty((len(faults), 0))
        if self._places:
            found = (
                encoding.integers(encoding.lists(counts[0]))
                if counts
                else [each[1:] for each in fitness]
            )
            table = np.array(found, self.violations.dtype)
            violations = table.reshape(len(faults), len(self._recorded))[:, self._places]
        costs = [*map(len, faults)] if self._minimised == "faults" else fault_ticks
        return faults, texts, np.array([float(first) for first, *_ in fitness]), violations, costs

    def take(
        self,
        faults: Sequence[Sequence[str]],
        texts: Sequence[Sequence[str]],
        fitness: NDArray[np.float64],
        violations: NDArray[Any],
        costs: Sequence[int],
    ) -> None:
        """Take the next rows."""
        these = slice(self._n_read, self._n_read + len(faults))
        self._n_read = these.stop
        self.fitness[these] = fitness
        self.violations[these] = violations
        if self._minimised:
            self.costs[these] = costs
        self.keys[these] = np.frombuffer(b"".join(map(_key, texts)), np.uint64)
        for place in self._first_of(self.keys[these]):
            self.is_first[these.start + place] = True
            self.tried.update(faults[place])

    def _first_of(self, keys: NDArray[np.uint64]) -> list[int]:
        """Return where keys stand that were not met before, each once, and remember them."""
        new, first = np.unique(keys, return_index=True)
        places = np.searchsorted(self._known, new)
        is_new = np.append(self._known, new[-1] + 1)[places] != new
        self._known = np.insert(self._known, places[is_new], new[is_new])
        return sorted(first[is_new].tolist())


def _key(texts: Sequence[str]) -> bytes:
    return blake2b("]],[".join(sorted(texts)).encode(), digest_size=8).digest()
