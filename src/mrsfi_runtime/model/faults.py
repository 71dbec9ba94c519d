"""Faults of a pool, and timed faults: what search arranges into fault specifications.

References
----------
Source paper, sections III-B b) and III-E a).
"""

from collections import defaultdict
from collections.abc import Callable, Collection, Container, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from enum import IntEnum
from functools import cached_property
from itertools import count
from typing import NamedTuple, Self, TypeAlias

from mrsfi_runtime.errors import SpecificationError, counted, expected
from mrsfi_runtime.model.fault_types import FaultType
from mrsfi_runtime.model.mission import Area

OwnValue: TypeAlias = "str | float | Mapping[str, OwnValue] | tuple[OwnValue, ...] | None"
"""Value of a feature that a team has added to a metamodel; a mapping is a part."""


class Event(IntEnum):
    """What can set faults off, judged in truth at the end of a tick."""

    VIOLATED = 0  # a goal is violated
    REACHED = 1  # a goal has all its samples, or its robots were where they were to go
    ENTERED = 2  # a robot is in an area
    EFFECT = 3  # a fault has changed something


@dataclass(frozen=True, slots=True)
class Trigger:
    """An event that sets faults off, when it first happens in a flight.

    ``of`` are the IDs of what it happens to: a goal, a robot that enters the ``area``, or faults,
    any of which will do. A fault that waits for it acts ``delay`` ticks after the tick that
    follows, for ``duration`` ticks at most; ``None`` is to the end of its window.
    """

    id: str
    event: Event
    of: tuple[str, ...]
    area: Area | None = None
    delay: int = 0
    duration: int | None = None

    @property
    def words(self) -> str:
        """When faults act that wait for it: ``when g4 is reached, 5 ticks later, for 9 ticks``."""
        lasts = "" if self.duration is None else f", for {counted(self.duration, 'ticks')}"
        return self.when + lasts

    @property
    def when(self) -> str:
        """When faults begin that wait for it: ``when g4 is reached, 5 ticks later``."""
        area = self.area.id if self.area else "no area"
        happens = ("is violated", "is reached", f"enters {area}", "changes something")[self.event]
        later = f", {counted(self.delay, 'ticks')} later" if self.delay else ""
        return f"when {' or '.join(self.of) or 'nothing'} {happens}{later}"


@dataclass(frozen=True, slots=True)
class Fault:
    """A fault of the pool.

    ``target`` is the ID of a message, robot, sensor or obstacle, as ``kind.struck`` says.
    ``values`` follow ``kind.parameters``. ``bounds`` holds what the model says about the
    range of an evolving parameter: name to (lowest, highest), ``None`` where it is silent.
    ``start`` and ``finish``, and the ID of a ``trigger`` that it waits for, are set in a written
    fault specification, not in a pool.
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
    trigger: str = ""

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

    ``fault`` is the ID of the pool fault; ``values`` replace those of the pool. One with a
    ``trigger``, by its ID, is active in that window from when its trigger sets it off.
    """

    fault: str
    start: int
    finish: int
    values: tuple[float, ...] = ()
    trigger: str = ""


Specification: TypeAlias = tuple[TimedFault, ...]
"""A fault specification: the timed faults of one run, no two conflicting ones overlapping."""


def numbered(faults: Iterable[str]) -> tuple[str, ...]:
    """Return a name for each timed fault, by pool faults: ``f9.1``, ``f9.2`` for two of ``f9``."""
    numbers: dict[str, count[int]] = defaultdict(lambda: count(1))
    return tuple(f"{fault}.{next(numbers[fault])}" for fault in faults)


def original(name: str, faults: Container[str]) -> str:
    """Return which of some faults a timed one is by its name; with a number, a copy of it."""
    base, _, number = name.rpartition(".")
    return base if base and name not in faults and number.isdecimal() else name


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
    """The faults that could strike a mission, and what could set them off, both in model order.

    ``own`` is as for a fault.
    """

    id: str
    faults: tuple[Fault, ...]
    own: Mapping[str, OwnValue] = field(default_factory=dict)
    triggers: tuple[Trigger, ...] = ()

    @cached_property
    def by_id(self) -> dict[str, Fault]:
        """Faults by ID."""
        return {fault.id: fault for fault in self.faults}

    @cached_property
    def triggers_by_id(self) -> dict[str, Trigger]:
        """Triggers by ID."""
        return {trigger.id: trigger for trigger in self.triggers}

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
            timed.append(
                TimedFault(fault.id, fault.start, fault.finish, fault.values, fault.trigger)
            )
        return tuple(timed)
