"""What search may choose from: faults, windows and values, and what excludes what.

References
----------
Source paper, sections III-C b) and III-E a) to c).
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from random import Random
from types import MappingProxyType
from typing import Self, TypeAlias

from mrsfi_runtime.errors import SpecificationError
from mrsfi_runtime.model.bounds import value_bounds
from mrsfi_runtime.model.faults import FaultPool, Specification, TimedFault
from mrsfi_runtime.model.mission import Mission
from mrsfi_runtime.model.targets import conflicts
from mrsfi_runtime.search.landmarks import landmarks

Window: TypeAlias = tuple[int, int]
"""First and last tick, both included."""


@dataclass(frozen=True, slots=True)
class Candidate:
    """What search may do with one fault of the pool.

    Attributes
    ----------
    index
        Place in the pool.
    values
        The pool's own values, shape ``(n_parameters,)``.
    bounds
        Lowest and highest of each value, shape ``(n_parameters, 2)``; equal if it is fixed.
    is_integer
        Whether each value is a whole number, shape ``(n_parameters,)``.
    conflicts
        IDs of the faults that it may not overlap, its own included.
    landmarks
        Values within the bounds that mean something in the mission, the pool's own first;
        shape ``(n_landmarks, n_parameters)``.
    is_place
        Whether the values are coordinates.
    """

    index: int
    values: tuple[float, ...]
    bounds: tuple[tuple[float, float], ...]
    is_integer: tuple[bool, ...]
    conflicts: frozenset[str]
    landmarks: tuple[tuple[float, ...], ...] = ()
    is_place: bool = False


@dataclass(frozen=True, slots=True)
class SearchSpace:
    """All fault specifications of one mission and pool; ``candidates`` in pool order."""

    duration: int
    candidates: Mapping[str, Candidate]

    @classmethod
    def of(cls, mission: Mission, pool: FaultPool) -> Self:
        """Return the space of a mission and its fault pool.

        Raises
        ------
        SpecificationError
            If the pool is empty or refers to an element that the mission does not have.
        """
        if not len(pool):
            raise SpecificationError(
                f"fault pool '{pool.id}' is empty; search needs at least one fault"
            )
        excluded = conflicts(mission, pool)
        candidates = {
            fault.id: Candidate(
                index=index,
                values=fault.values,
                bounds=value_bounds(mission, fault),
                is_integer=tuple(parameter.is_integer for parameter in fault.kind.parameters),
                conflicts=excluded[fault.id],
                landmarks=landmarks(mission, fault),
                is_place=fault.kind.is_place,
            )
            for index, fault in enumerate(pool)
        }
        return cls(mission.duration, MappingProxyType(candidates))

    def clash(self, first: TimedFault, second: TimedFault) -> bool:
        """Return whether two timed faults may not stand in one specification."""
        return (
            first.start <= second.finish
            and second.start <= first.finish
            and second.fault in self.candidates[first.fault].conflicts
        )

    def require(self, specification: Specification, where: str) -> Specification:
        """Return a specification as the record has it, or refuse it.

        Parameters
        ----------
        where
            Who made it, for the message.

        Raises
        ------
        SpecificationError
            If a fault, a window or a value is none of this space, or two faults clash.
        """
        for timed in specification:
            if not self._has(timed):
                raise SpecificationError(
                    f"{where} made {timed}; expected a fault of the pool, its window within "
                    f"0 … {self.duration - 1} and its values within the bounds of the model"
                )
        for first, second in combinations(specification, 2):
            if self.clash(first, second):
                raise SpecificationError(
                    f"{where} made {first} and {second}, which conflict and overlap; "
                    "SearchSpace.free_windows says where there is room"
                )
        return self.ordered(specification)

    def _has(self, timed: TimedFault) -> bool:
        candidate = self.candidates.get(timed.fault)
        return (
            candidate is not None
            and 0 <= timed.start <= timed.finish < self.duration
            and len(timed.values) == len(candidate.bounds)
            and all(
                low <= value <= high
                for value, (low, high) in zip(timed.values, candidate.bounds, strict=True)
            )
        )

    def ordered(self, faults: Iterable[TimedFault]) -> Specification:
        """Return timed faults by start, finish and place in the pool.

        One set of timed faults has one order, hence one record and one outcome. No two of
        a valid specification are equal in all three.
        """
        return tuple(
            sorted(
                faults,
                key=lambda timed: (timed.start, timed.finish, self.candidates[timed.fault].index),
            )
        )

    def free_windows(self, fault: str, others: Iterable[TimedFault]) -> list[Window]:
        """Return the longest windows in which a fault conflicts with no other, in order."""
        excluded = self.candidates[fault].conflicts
        taken = sorted((other.start, other.finish) for other in others if other.fault in excluded)
        free = []
        tick = 0
        for start, finish in taken:
            if start > tick:
                free.append((tick, start - 1))
            tick = max(tick, finish + 1)
        if tick < self.duration:
            free.append((tick, self.duration - 1))
        return free


def random_window(free: Sequence[Window], rng: Random) -> Window:
    """Draw a window inside one of several free ones.

    Every window comes as often as if a start and a finish were drawn from the whole
    mission, and both drawn again until the window is free.
    """
    n_pairs = [(last - first + 1) ** 2 for first, last in free]
    ((first, last),) = rng.choices(free, weights=n_pairs)
    one, other = rng.randrange(first, last + 1), rng.randrange(first, last + 1)
    return (one, other) if one <= other else (other, one)
