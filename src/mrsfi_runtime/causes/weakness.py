"""Weaknesses: the least sets of a pool's faults that break a goal, and what is known of them.

A goal is judged by three measures; one goal by one measure is a ``Column``. It is *broken* by a
flight whose count is above 0, or, where the flight without faults has a count already, above that
by more than ``MARGIN`` of the mission's ticks. A set of faults is *minimal* if none of its parts is
known to break the same column.
"""

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any, Self, TypeAlias

from mrsfi_runtime.causes.cause_set import without
from mrsfi_runtime.causes.counts import Column, EvaluateIn
from mrsfi_runtime.errors import EvaluationError
from mrsfi_runtime.model.faults import Specification, TimedFault
from mrsfi_runtime.model.mission import Mission
from mrsfi_runtime.model.outcome import Outcome

MEASURES = ("believed", "true", "missed")
"""Counts of an outcome by which a goal may be broken; masked and phantom follow from two."""

MARGIN = 0.05
"""Share of a mission's ticks by which a count has to exceed that of the flight without faults."""

_DOUBT = 0.05

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
    n_kept
        How many random specifications without a set that is known to break a column have kept it,
        one after the other, since the last such set was found.
    """

    def __init__(self, mission: Mission) -> None:
        self.sets: dict[Column, list[FaultSet]] = {column: [] for column in columns(mission)}
        self.flown: dict[Specification, Broken] = {}
        self.n_kept = dict.fromkeys(self.sets, 0)
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
            self.n_kept[column] = 0

    def bound(self, column: Column) -> float:
        """Return the chance, 0 … 1, that such a random specification breaks a column, at most.

        It is an upper bound at a confidence of 95 %: of zero in ``n_kept``, after Clopper and
        Pearson.
        """
        n = self.n_kept[column]
        return 1.0 - _DOUBT ** (1.0 / n) if n else 1.0

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

    def weaknesses(self) -> "tuple[Weakness, ...]":
        """Return what is known to break each column: small sets first, then by share of forms."""
        found = (
            self._weakness(column, faults) for column, sets in self.sets.items() for faults in sets
        )
        place = {column: number for number, column in enumerate(self.sets)}
        return tuple(
            sorted(
                found,
                key=lambda each: (
                    place[each.column],
                    len(each.faults),
                    -each.share,
                    each.faults,
                ),
            )
        )

    def _weakness(self, column: Column, faults: FaultSet) -> "Weakness":
        witness = min(self.breaking(column, faults), key=_mildness)
        is_masked = Column(column.goal, "believed") not in self.flown[witness]
        return Weakness(
            column, tuple(sorted(faults)), witness, *self.tries(column, faults), is_masked
        )


def _mildness(specification: Specification) -> tuple[int, Specification]:
    return sum(timed.finish - timed.start for timed in specification), specification


@dataclass(frozen=True, slots=True)
class Weakness:
    """A goal, a measure, and a minimal set of faults that breaks it.

    Attributes
    ----------
    column
        The goal and the measure.
    faults
        IDs of the pool's faults, sorted.
    witness
        Of the forms tried that break it, the one at work for the fewest ticks.
    n_tried, n_broken
        How many different forms of just these faults were flown, and how many broke it.
    is_masked
        Whether the collective intelligence does not believe the goal broken under the witness.
    n_held, n_seeds
        In how many mission seeds, of those that were looked at, the witness breaks it and no part
        of the witness does.
    """

    column: Column
    faults: tuple[str, ...]
    witness: Specification
    n_tried: int
    n_broken: int
    is_masked: bool
    n_held: int = 1
    n_seeds: int = 1

    @property
    def share(self) -> float:
        """Share of the forms tried that broke it, above 0, at most 1."""
        return self.n_broken / self.n_tried

    def as_json(self) -> dict[str, Any]:
        """Return it as plain values."""
        return {
            "goal": self.column.goal,
            "measure": self.column.kind,
            "faults": list(self.faults),
            "witness": [
                dict(zip(TimedFault._fields, timed, strict=True)) for timed in self.witness
            ],
            "share": self.share,
            "tried": self.n_tried,
            "seeds": {"held": self.n_held, "of": self.n_seeds},
            "masked": self.is_masked,
        }


def in_seeds(
    mission: Mission, found: Sequence[Weakness], evaluate: EvaluateIn, seeds: Sequence[int]
) -> tuple[Weakness, ...]:
    """Return weaknesses with the number of mission seeds in which they hold.

    What fails breaks nothing; without faults it may not fail.
    """
    parts = {
        each.witness: [without(each.witness, place) for place in range(len(each.witness))]
        for each in found
    }
    flown = tuple(dict.fromkeys([(), *parts, *(part for some in parts.values() for part in some)]))
    n_held: Counter[Weakness] = Counter()
    for seed in seeds:
        outcomes = dict(zip(flown, evaluate(flown, seed), strict=True))
        fault_free = outcomes[()]
        if not isinstance(fault_free, Outcome):
            raise EvaluationError(f"without faults, in mission seed {seed}: {fault_free.traceback}")
        yardstick = Yardstick.of(mission, fault_free)
        broken = {
            each: yardstick.broken(outcome) if isinstance(outcome, Outcome) else frozenset[Column]()
            for each, outcome in outcomes.items()
        }
        for each in found:
            alone = (broken[part] for part in parts[each.witness])
            n_held[each] += each.column in broken[each.witness].difference(*alone)
    return tuple(replace(each, n_held=n_held[each], n_seeds=len(seeds)) for each in found)
