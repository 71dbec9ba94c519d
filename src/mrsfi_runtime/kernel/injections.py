"""Faults at work: every timed fault laid out as injections, one per property it touches.

References
----------
Source paper, sections III-B b) and III-G; DESIGN of the fault effects in docs/semantics.md.
"""

from dataclasses import dataclass
from operator import attrgetter
from typing import NamedTuple

from mrsfi_runtime.model.fault_types import Field, Mode
from mrsfi_runtime.model.faults import FaultPool, Specification, TimedFault
from mrsfi_runtime.model.mission import Mission
from mrsfi_runtime.model.targets import touched


@dataclass(slots=True)
class InjectionState:
    """One property of one target under one fault, active for ``start <= tick <= finish``.

    ``affected`` and ``mode`` are numbers of ``Field`` and ``Mode``; ``a``, ``b``, ``c`` the
    fault's values. A delay of ``n_held`` ticks keeps what is under way in a ring of ``Plan.held``
    from ``first_held`` on, three entries a tick; 0 means that nothing arrives in the window.
    ``kept_…`` is what was believed before this tick's delivery.
    """

    fault: int
    affected: int
    mode: int
    target: int
    start: int
    finish: int
    a: float
    b: float
    c: float
    first_held: int
    n_held: int
    kept_a: float
    kept_b: float
    kept_c: float


@dataclass(slots=True)
class FaultTally:
    """At how many ticks a timed fault was active, and at how many it changed a value."""

    applied: int
    changed: int
    last_applied: int
    last_changed: int


@dataclass(slots=True)
class Plan:
    """All injections of one fault specification, by what they act on, each list by start.

    ``messages`` are delayed and blocked ones, ``reports`` falsify what is believed,
    ``commands`` are forged. ``held`` is room for delayed messages; ``tallies`` has one entry
    for each timed fault.
    """

    messages: list[InjectionState]
    reports: list[InjectionState]
    commands: list[InjectionState]
    held: list[float]
    tallies: list[FaultTally]


class InjectionRow(NamedTuple):
    """What an injection is before its run: the first attributes of ``InjectionState``."""

    fault: int
    affected: int
    mode: int
    target: int
    start: int
    finish: int
    a: float
    b: float
    c: float
    first_held: int
    n_held: int


class PlanRows(NamedTuple):
    """A plan before its run.

    Attributes
    ----------
    lists
        Messages, reports and commands, each by start.
    n_held
        Numbers that delays hold back.
    n_faults
        Number of timed faults.
    """

    lists: tuple[list[InjectionRow], list[InjectionRow], list[InjectionRow]]
    n_held: int
    n_faults: int


def plan(mission: Mission, pool: FaultPool, specification: Specification) -> Plan:
    """Lay a fault specification out for the kernel.

    Raises
    ------
    SpecificationError
        If a fault is not in the pool, or refers to what the mission does not have.
    """
    lists, n_held, n_faults = plan_rows(mission, pool, specification)
    messages, reports, commands = (
        [InjectionState(*row, 0.0, 0.0, 0.0) for row in rows] for rows in lists
    )
    tallies = [FaultTally(0, 0, -1, -1) for _ in range(n_faults)]
    return Plan(messages, reports, commands, [0.0] * n_held, tallies)


def plan_rows(mission: Mission, pool: FaultPool, specification: Specification) -> PlanRows:
    """Lay a fault specification out as rows; as ``plan``."""
    rows = PlanRows(([], [], []), 0, len(specification))
    messages, reports, commands = rows.lists
    n_held = 0
    for number, timed in enumerate(specification):
        fault = pool[timed.fault]
        mode = int(fault.kind.mode)
        for field, target in touched(mission, fault):
            affected = int(field)
            if mode in _HELD_BACK:
                row = _held_back(number, timed, affected, mode, target, n_held)
                n_held += 3 * row.n_held
                messages.append(row)
            else:
                a, b, c = _values(timed)
                row = InjectionRow(
                    number, affected, mode, target, timed.start, timed.finish, a, b, c, 0, 0
                )
                (commands if affected in _COMMANDED else reports).append(row)
    for injections in rows.lists:
        injections.sort(key=_start)
    return rows._replace(n_held=n_held)


_start = attrgetter("start")


def _values(timed: TimedFault) -> tuple[float, float, float]:
    a, b, c = (*map(float, timed.values), 0.0, 0.0, 0.0)[:3]
    return a, b, c


def _held_back(
    number: int, timed: TimedFault, affected: int, mode: int, target: int, first_held: int
) -> InjectionRow:
    """Return a row of a message fault; a delay below one tick never becomes active."""
    a, b, c = _values(timed)
    finish = timed.finish
    n_held = 0
    if mode == BLOCK:
        finish = min(finish, timed.start + round(a) - 1)
    elif round(a) < 1:
        finish = timed.start - 1
    elif round(a) <= finish - timed.start:
        n_held = round(a)
    first = first_held if n_held else 0
    return InjectionRow(number, affected, mode, target, timed.start, finish, a, b, c, first, n_held)


POSITION = int(Field.POSITION)
SPEED = int(Field.SPEED)
ENERGY = int(Field.ENERGY)
COUNT = int(Field.COUNT)
RATE = int(Field.RATE)
COST = int(Field.COST)
OBSTACLE = int(Field.OBSTACLE)
MOTION = int(Field.MOTION)
ACTIVATION = int(Field.ACTIVATION)

DELAY = int(Mode.DELAY)
BLOCK = int(Mode.BLOCK)
RANDOM = int(Mode.RANDOM)
ZERO = int(Mode.ZERO)
FIXED = int(Mode.FIXED)
INCREMENT = int(Mode.INCREMENT)
DECREMENT = int(Mode.DECREMENT)
INCREMENT_PERCENT = int(Mode.INCREMENT_PERCENT)
DECREMENT_PERCENT = int(Mode.DECREMENT_PERCENT)
STOP = int(Mode.STOP)
START = int(Mode.START)
DEACTIVATE = int(Mode.DEACTIVATE)
ACTIVATE = int(Mode.ACTIVATE)

_HELD_BACK = (DELAY, BLOCK)
_COMMANDED = (MOTION, ACTIVATION)
