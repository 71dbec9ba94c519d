"""Faults at work: every timed fault laid out as injections, one per property it touches.

References
----------
Source paper, sections III-B b) and III-G; DESIGN of the fault effects in docs/semantics.md.
"""

from array import array
from collections.abc import Callable, Iterator, MutableSequence, Sequence
from dataclasses import dataclass, field
from operator import attrgetter
from typing import NamedTuple, TypeAlias

from mrsfi_runtime.kernel.state import N_MEMORY, State
from mrsfi_runtime.model import fault_types
from mrsfi_runtime.model.fault_types import FaultType, Field, Mode
from mrsfi_runtime.model.faults import FaultPool, Specification, TimedFault
from mrsfi_runtime.model.mission import Mission
from mrsfi_runtime.model.targets import Target, touched


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


def _numbers() -> MutableSequence[float]:
    return array("d", bytes(8 * N_MEMORY))


@dataclass(slots=True)
class OwnFault:
    """A fault of a team's own type at work on one target, active for ``start <= tick <= finish``.

    ``target`` is the index of a robot, a sensor or an obstacle. ``values`` are those of the
    fault's parameters, ``age`` the ticks since its start, ``memory`` numbers that are 0 at its
    start. ``fault``, ``effect`` and ``kind`` say which fault it is, which effect it has, and on
    what.
    """

    fault: int
    effect: int
    kind: int
    target: int
    start: int
    finish: int
    age: int = 0
    values: MutableSequence[float] = field(default_factory=_numbers)
    memory: MutableSequence[float] = field(default_factory=_numbers)


OwnEffect: TypeAlias = Callable[[State, State, OwnFault], None]
"""Changes the local state, the first argument; the second holds the newest messages."""


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
    ``commands`` are forged, ``own`` are those of a team's own types. ``held`` is room for delayed
    messages; ``tallies`` has one entry for each timed fault.
    """

    messages: list[InjectionState]
    reports: list[InjectionState]
    commands: list[InjectionState]
    held: list[float]
    tallies: list[FaultTally]
    own: list[OwnFault]


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


class OwnRow(NamedTuple):
    """What a fault of a team's own type is before its run: attributes of ``OwnFault``."""

    fault: int
    effect: int
    kind: int
    target: int
    start: int
    finish: int
    values: tuple[float, ...]


class PlanRows(NamedTuple):
    """A plan before its run.

    Attributes
    ----------
    lists
        Messages, reports and commands, each by start.
    own
        Faults of a team's own types, by start.
    n_held
        Numbers that delays hold back.
    n_faults
        Number of timed faults.
    """

    lists: tuple[list[InjectionRow], list[InjectionRow], list[InjectionRow]]
    own: list[OwnRow]
    n_held: int
    n_faults: int


def plan(mission: Mission, pool: FaultPool, specification: Specification) -> Plan:
    """Lay a fault specification out for the kernel.

    Raises
    ------
    SpecificationError
        If a fault is not in the pool, or refers to what the mission does not have.
    """
    lists, own, n_held, n_faults = plan_rows(mission, pool, specification)
    messages, reports, commands = (
        [InjectionState(*row, 0.0, 0.0, 0.0) for row in rows] for rows in lists
    )
    tallies = [FaultTally(0, 0, -1, -1) for _ in range(n_faults)]
    return Plan(
        messages, reports, commands, [0.0] * n_held, tallies, [_own_fault(row) for row in own]
    )


def _own_fault(row: OwnRow) -> OwnFault:
    fault = OwnFault(*row[:-1])
    for place, value in enumerate(row.values):
        fault.values[place] = value
    return fault


def plan_rows(mission: Mission, pool: FaultPool, specification: Specification) -> PlanRows:
    """Lay a fault specification out as rows; as ``plan``."""
    rows = PlanRows(([], [], []), [], 0, len(specification))
    messages, reports, commands = rows.lists
    n_held = 0
    for number, timed in enumerate(specification):
        fault = pool[timed.fault]
        if fault.kind.mode is Mode.OWN:
            rows.own.extend(_own_rows(number, timed, fault.kind, touched(mission, fault)))
            continue
        mode = int(fault.kind.mode)
        for touched_field, target in touched(mission, fault):
            affected = int(touched_field)
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
    rows.own.sort(key=_start)
    return rows._replace(n_held=n_held)


_start = attrgetter("start")


def _values(timed: TimedFault) -> tuple[float, float, float]:
    a, b, c = (*map(float, timed.values), 0.0, 0.0, 0.0)[:3]
    return a, b, c


def _own_rows(
    number: int, timed: TimedFault, kind: FaultType, targets: Sequence[Target]
) -> Iterator[OwnRow]:
    """Yield a row for each target of which all is touched that the fault's type names."""
    values = tuple(map(float, timed.values))
    for target in dict.fromkeys(index for _, index in targets):
        if all((affected, target) in targets for affected in kind.properties):
            of = _KINDS[kind.properties[0]]
            yield OwnRow(number, kind.effect, of, target, timed.start, timed.finish, values)


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

OF_ROBOT, OF_SENSOR, OF_OBSTACLE = 0, 1, 2
"""On what a fault of a team's own type acts."""

_KINDS = {
    **dict.fromkeys(fault_types.OF_ROBOT, OF_ROBOT),
    **dict.fromkeys(fault_types.OF_SENSOR, OF_SENSOR),
    Field.OBSTACLE: OF_OBSTACLE,
}

_HELD_BACK = (DELAY, BLOCK)
_COMMANDED = (MOTION, ACTIVATION)
