"""What a report asks of all evaluations, in arrays: tens of bytes for each, and no object.

A specification is told by eight bytes of a hash over its timed faults, in whatever order they
stand. In a campaign of a million evaluations two different ones have the same with a chance of
three in a hundred million; one of them would then not be counted as distinct.
"""

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from hashlib import blake2b
from typing import Any, Self, TypeAlias

import numpy as np
from numpy.typing import NDArray

from mrsfi_runtime.record import database
from mrsfi_runtime.record.store import CampaignStore, Evaluation, Measure

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
        """Read the evaluations of a campaign, for goals by their IDs that the record has."""
        measure.require(goals)
        n, n_read = store.n_evaluations, 0
        names, decoded = _decoding(measure, goals)
        kind = np.float64 if measure.n_seeds > 1 else np.int64  # means are no whole numbers
        fitness, violations = np.empty(n), np.empty((n, len(goals)), kind)
        costs, keys = np.empty(n, np.int64), np.empty(n, np.uint64)
        is_first, known = np.zeros(n, bool), np.empty(0, np.uint64)
        tried: Counter[str] = Counter()
        for faults, texts, *numbers in store.stored(names, n, decoded):
            these = slice(n_read, n_read + len(faults))
            fitness[these], violations[these], costs[these] = numbers
            keys[these] = np.frombuffer(b"".join(map(_key, texts)), np.uint64)
            known, places = _met(known, keys[these])
            for place in places:
                is_first[n_read + place] = True
                tried.update(faults[place])
            n_read = these.stop
        distinct = np.flatnonzero(is_first)
        return cls(tuple(goals), fitness, violations, costs, distinct, tried, keys)

    def __len__(self) -> int:
        return len(self.fitness)

    def of(self, goals: Sequence[str]) -> NDArray[Any]:
        """Return the violations of some goals, shape ``(n_evaluations, n_goals)``."""
        return self.violations[:, [self.goals.index(goal) for goal in goals]]

    def top(self, n: int) -> tuple[int, ...]:
        """Return the ``n`` most critical distinct evaluations, or all; of equals the first."""
        ranked = np.argsort(-self.fitness[self.distinct], kind="stable")
        return tuple(self.distinct[ranked[:n]].tolist())

    def distinct_among(self, rows: Sequence[int]) -> Rows:
        """Return the first of every specification among some evaluations."""
        found = np.unique(np.array(rows, np.intp))
        return found[np.sort(np.unique(self._keys[found], return_index=True)[1])]


def top(store: CampaignStore, measure: Measure, n: int) -> tuple[Evaluation, ...]:
    """Return the ``n`` most critical distinct evaluations of a campaign, or all if it has fewer."""
    return tuple(store.evaluation(index) for index in Columns.read(store, measure).top(n))


def _decoding(
    measure: Measure, goals: Sequence[str]
) -> tuple[tuple[str, ...], Callable[[Sequence[Sequence[Any]]], tuple[Any, ...]]]:
    """Return which columns of a store are read, and what decodes some rows of them."""
    is_mean = measure.n_seeds > 1
    recorded = measure.chosen if is_mean else measure.goals
    places = [recorded.index(goal) for goal in goals]
    counted = () if is_mean or not goals else (measure.kind,)

    def decoded(stored: Sequence[Sequence[Any]]) -> tuple[Any, ...]:
        """Return faults, texts of timed faults, fitness, violations and costs."""
        specifications, fitness_texts, fault_ticks, *counts = stored
        faults, texts = zip(*map(database.fault_texts, specifications), strict=True)
        fitness = database.lists(fitness_texts)
        violations: NDArray[Any] = np.empty((len(faults), 0))
        if places:
            found = (
                database.integers(database.lists(counts[0]))
                if counts
                else [each[1:] for each in fitness]
            )
            table = np.array(found, np.float64 if is_mean else np.int64)
            violations = table.reshape(len(faults), len(recorded))[:, places]
        costs = [*map(len, faults)] if measure.minimised == "faults" else fault_ticks
        ranked_by = np.array([float(first) for first, *_ in fitness])
        return faults, texts, ranked_by, violations, costs if measure.minimised else 0

    return ("specification", "fitness", "fault_ticks", *counted), decoded


def _met(
    known: NDArray[np.uint64], keys: NDArray[np.uint64]
) -> tuple[NDArray[np.uint64], list[int]]:
    """Return all keys that were met, ascending, and where those stand that were not before."""
    new, first = np.unique(keys, return_index=True)
    places = np.searchsorted(known, new)
    is_new = np.append(known, new[-1] + 1)[places] != new
    return np.insert(known, places[is_new], new[is_new]), sorted(first[is_new].tolist())


def _key(texts: Sequence[str]) -> bytes:
    return blake2b("]],[".join(sorted(texts)).encode(), digest_size=8).digest()
