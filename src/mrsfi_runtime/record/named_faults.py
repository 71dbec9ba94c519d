"""How timed faults are named wherever people and scripts read of them."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

from mrsfi_runtime.kernel.injections import FaultTally, active_window, longest
from mrsfi_runtime.model.fault_types import Units
from mrsfi_runtime.model.faults import (
    LAST,
    Fault,
    FaultPool,
    Specification,
    TimedFault,
    Trigger,
    describe,
    robots_of,
    touched,
)
from mrsfi_runtime.model.mission import Mission

Window: TypeAlias = tuple[int, int]
"""First and last tick."""


@dataclass(frozen=True, slots=True)
class NamedFault:
    """A timed fault, and all that it takes to name it.

    ``touched`` is in words, ``robots`` are the places of the robots that have it or carry the
    sensors that do; ``window`` has the first and last tick at which it is active, ``None`` if it
    never is; ``units`` are those of the mission. One with a ``trigger`` is active at ``most`` ticks
    of it.
    """

    name: str
    timed: TimedFault
    fault: Fault
    touched: tuple[str, ...]
    robots: frozenset[int]
    window: Window | None
    units: Units
    trigger: Trigger | None = None
    most: int = LAST

    @property
    def target(self) -> str:
        """What it touches, after what it refers to unless that says the same: ``m8: r2 speed``."""
        refers = self.fault.target
        words = ", ".join(self.touched) or "nothing"
        is_said = bool(self.touched) and all(each.startswith(f"{refers} ") for each in self.touched)
        return words if is_said else f"{refers}: {words}"

    @property
    def words(self) -> str:
        """Its type, and its target: ``FixedSpeed on m8: r2 speed``."""
        return f"{self.fault.type} on {self.target}"

    @property
    def values(self) -> str:
        """Its values with names and units; empty if its type has no parameters."""
        return self.fault.kind.in_words(self.timed.values, self.units)

    @property
    def told(self) -> str:
        """Its values, and what it waits for; empty if it has neither."""
        waits = "" if self.trigger is None else self.trigger.words
        return "; ".join(filter(None, (self.values, waits)))

    def active(self, tally: FaultTally) -> Window | None:
        """Return when it is active in a flight, as far as that is known from what it did until now.

        A fault that waits for a trigger was active at all ticks from its first one on.
        """
        if self.trigger is None or self.window is None or not tally.applied:
            return self.window if self.trigger is None else None
        first = tally.last_applied - tally.applied + 1
        return first, min(self.window[1], first + self.most - 1)

    def as_json(self) -> dict[str, Any]:
        """Return all of it but its ID as plain values."""
        waits = {"trigger": self.trigger.id} if self.trigger is not None else {}
        return {
            "type": self.fault.type,
            "target": self.fault.target,
            "touched": list(self.touched),
            "start": self.timed.start,
            "finish": self.timed.finish,
            "window": None if self.window is None else list(self.window),
            "values": self.fault.kind.named(self.timed.values),
            **waits,
        }


def named_faults(
    mission: Mission,
    pool: FaultPool,
    specification: Specification,
    names: Sequence[str] | None = None,
) -> tuple[NamedFault, ...]:
    """Return the faults of a specification; ``names`` are IDs of the pool if left out."""
    if names is None:
        names = [timed.fault for timed in specification]
    found = []
    for name, timed in zip(names, specification, strict=True):
        fault = pool[timed.fault]
        targets = touched(mission, fault)
        words = tuple(describe(mission, target) for target in targets)
        window = active_window(mission, pool, timed)
        robots, trigger = robots_of(mission, targets), pool.triggers_by_id.get(timed.trigger)
        most = LAST if trigger is None else longest(fault.kind, timed.values, trigger)
        told = (window, mission.units, trigger, most)
        found.append(NamedFault(name, timed, fault, words, robots, *told))
    return tuple(found)
