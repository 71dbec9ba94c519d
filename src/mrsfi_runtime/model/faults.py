"""Faults of a pool, and timed faults: what search arranges into fault specifications.

References
----------
Source paper, sections III-B b) and III-E a).
"""

from collections import defaultdict
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import count
from typing import NamedTuple, Self, TypeAlias

from mrsfi_runtime.errors import SpecificationError, expected
from mrsfi_runtime.model.fault_types import FaultType

OwnValue: TypeAlias = "str | float | Mapping[str, OwnValue] | tuple[OwnValue, ...] | None"
"""Value of a feature that a team has added to a metamodel; a mapping is a part."""


@dataclass(frozen=True, slots=True)
class Fault:
    """A fault of the pool.

    ``target`` is the ID of a message, robot, sensor or obstacle, as ``kind.struck`` says.
    ``values`` follow ``kind.parameters``. ``bounds`` holds what the model says about the
    range of an evolving parameter: name to (lowest, highest), ``None`` where it is silent.
    ``start`` and ``finish`` are set in a written fault specification, not in a pool.
    ``likelihood`` is the chance that it occurs in a mission, 0 … 1, ``None`` if nobody knows.
    ``own`` holds what a team has added to the class of faults, or to that of their type.
    """

    id: str
    kind: FaultType
    target: str
    values: tuple[float, ...] = ()
    bounds: Mapping[str, tuple[float | None, float | None]] = field(default_factory=dict)
    name: str = ""
    start: int | None = None
    finish: int | None = None
    likelihood: float | None = None
    own: Mapping[str, OwnValue] = field(default_factory=dict)

    @property
    def type(self) -> str:
        """Name of the fault's type."""
        return self.kind.name

    @property
    def words(self) -> str:
        """Its type, and what it refers to: ``FixedSpeed of m8``."""
        return f"{self.type} of {self.target}"


class TimedFault(NamedTuple):
    """A pool fault at work: active for ``start <= tick <= finish``.

    ``fault`` is the ID of the pool fault; ``values`` replace those of the pool.
    """

    fault: str
    start: int
    finish: int
    values: tuple[float, ...] = ()


Specification: TypeAlias = tuple[TimedFault, ...]
"""A fault specification: the timed faults of one run, no two conflicting ones overlapping."""


def numbered(faults: Iterable[str]) -> tuple[str, ...]:
    """Return a name for each timed fault, by pool faults: ``f9.1``, ``f9.2`` for two of ``f9``."""
    numbers: dict[str, count[int]] = defaultdict(lambda: count(1))
    return tuple(f"{fault}.{next(numbers[fault])}" for fault in faults)


def fault_ticks(specification: Specification, duration: int) -> int:
    """Return at how many ticks of a mission faults are active, summed over timed faults."""
    return sum(max(0, min(timed.finish + 1, duration) - timed.start) for timed in specification)


COSTS: Mapping[str, Callable[[Specification, int], int]] = {
    "faults": lambda specification, _: len(specification),
    "fault_ticks": fault_ticks,
}
"""What a search can keep few of, of a specification and the duration of its mission in ticks."""


@dataclass(frozen=True)
class FaultPool:
    """The faults that could strike a mission, in model order; ``own`` as for a fault."""

    id: str
    faults: tuple[Fault, ...]
    own: Mapping[str, OwnValue] = field(default_factory=dict)

    @cached_property
    def by_id(self) -> dict[str, Fault]:
        """Faults by ID."""
        return {fault.id: fault for fault in self.faults}

    def __getitem__(self, fault_id: str) -> Fault:
        try:
            return self.by_id[fault_id]
        except (KeyError, TypeError):
            known = expected(fault_id, self.by_id)
            raise SpecificationError(
                f"fault pool '{self.id}' has no fault {fault_id!r}; {known}"
            ) from None

    def __iter__(self) -> Iterator[Fault]:
        return iter(self.faults)

    def __len__(self) -> int:
        return len(self.faults)

    def without(self, faults: Collection[str]) -> Self:
        """Return the pool without some faults, by their IDs; itself if these are none."""
        left = tuple(fault for fault in self.faults if fault.id not in faults)
        return self if len(left) == len(self.faults) else replace(self, faults=left)

    def written_specification(self) -> Specification:
        """Return the faults of a written specification, each of which has to have a window."""
        timed = []
        for fault in self.faults:
            if fault.start is None or fault.finish is None:
                raise SpecificationError(
                    f"fault '{fault.id}' of '{self.id}' has no start and finish; "
                    "a specification that is to be flown needs both",
                    (fault.id,),
                )
            timed.append(TimedFault(fault.id, fault.start, fault.finish, fault.values))
        return tuple(timed)
