"""Weaknesses: the least sets of a pool's faults that break a goal, and what is known of them.

A goal is judged by three measures; one goal by one measure is a ``Column``. It is *broken* by a
flight whose count is above 0, or, where the flight without faults has a count already, above that
by more than ``MARGIN`` of the mission's ticks. A set of faults is *minimal* if none of its parts is
known to break the same column.
"""

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Self, TypeAlias

from mrsfi_runtime.causes.counts import Column
from mrsfi_runtime.model.faults import Specification
from mrsfi_runtime.model.mission import Mission
from mrsfi_runtime.model.outcome import Outcome

MEASURES = ("believed", "true", "missed")
"""Counts of an outcome by which a goal may be broken; masked and phantom follow from two."""

MARGIN = 0.05
"""Share of a mission's ticks by which a count has to exceed that of the flight without faults."""

FaultSet: TypeAlias = frozenset[str]
"""IDs of faults of a pool."""

Broken: TypeAlias = frozenset[Column]
"""The columns that a flight breaks."""


def columns(mission: Mission) -> tuple[Column, ...]:
    """Return what can be broken in a mission: every goal by every measure, in model order."""
    return tuple(Column(goal, measure) for goal in mission.goal_ids for measure in MEASURES)


@dataclass(frozen=True, slots=True)
class Yardstick:
    """Tells what a flight breaks in one mission seed, by the flight without faults there.

    ``most`` has for each column, in the order of ``columns``, the count up to which it is kept.
    """

    columns: tuple[Column, ...]
    most: tuple[float, ...]

    @classmethod
    def of(cls, mission: Mission, fault_free: Outcome) -> Self:
        """Return that of a mission whose flight without faults came to an outcome."""
        margin = MARGIN * mission.duration
        most = tuple(count + (margin if count else 0.0) for count in _counts(fault_free))
        return cls(columns(mission), most)

    def broken(self, outcome: Outcome) -> Broken:
        """Return the columns that a flight breaks."""
        judged = zip(self.columns, _counts(outcome), self.most, strict=True)
        return frozenset(column for column, count, most in judged if count > most)


def _counts(outcome: Outcome) -> Iterator[int]:
    """Yield the counts of an outcome by column; 0 where an older record does not say."""
    found = [getattr(outcome, measure) or (0,) * len(outcome.true) for measure in MEASURES]
    return (count for goal in zip(*found, strict=True) for count in goal)


def faults_of(specification: Specification) -> FaultSet:
    """Return the pool faults that a specification has."""
    return frozenset(timed.fault for timed in specification)


def form(specification: Specification) -> Specification:
    """Return a specification in an order that every other one with the same timed faults has."""
    return tuple(sorted(specification))


class Known:
    """What flights in one mission seed have shown: minimal sets by column, and every form tried.

    Attributes
    ----------
    sets
        The sets that are minimal as far as is known, in the order in which they were found.
    flown
        What each form that was tried breaks.
    """

    def __init__(self, mission: Mission) -> None:
        self.sets: dict[Column, list[FaultSet]] = {column: [] for column in columns(mission)}
        self.flown: dict[Specification, Broken] = {}
        self._n_tried: Counter[FaultSet] = Counter()
        self._n_broken: Counter[tuple[Column, FaultSet]] = Counter()

    def learn(self, specification: Specification, broken: Broken) -> None:
        """Take what a flight breaks; if of a single fault, that is a minimal set of each column."""
        tried = form(specification)
        if tried in self.flown:
            return
        self.flown[tried] = broken
        faults = faults_of(specification)
        self._n_tried[faults] += 1
        for column in broken:
            self._n_broken[column, faults] += 1
            if len(faults) == 1:
                self.add(column, faults)

    def add(self, column: Column, faults: FaultSet) -> None:
        """Take a set that breaks a column while none of its parts is known to."""
        if not self.has_part_of(column, faults):
            kept = (known for known in self.sets[column] if not faults <= known)
            self.sets[column] = [*kept, faults]

    def has_part_of(self, column: Column, faults: FaultSet) -> bool:
        """Return whether a set that breaks a column is among some faults."""
        return any(known <= faults for known in self.sets[column])

    def tries(self, column: Column, faults: FaultSet) -> tuple[int, int]:
        """Return how many forms of just these faults were tried, and how many broke a column."""
        return self._n_tried[faults], self._n_broken[column, faults]

    def breaking(self, column: Column, faults: FaultSet) -> Iterator[Specification]:
        """Yield the forms of just these faults that broke a column, in the order of the tries."""
        return (
            tried
            for tried, broken in self.flown.items()
            if column in broken and faults_of(tried) == faults
        )
