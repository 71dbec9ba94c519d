"""Plans for the kernel: each timed fault becomes injections, one per property that it affects.

``plan_rows`` turns a fault specification into rows, which a compiled engine copies into arrays;
``plan`` makes records of them. Each list is sorted by start, so that a tick stops reading at the
first injection that begins later. A fault that waits for a trigger has ``finish`` -1 there, and
an entry in ``waiting`` with its window once triggered.

Begin with ``InjectionState`` and ``Plan``, then ``plan_rows``.

References
----------
Source paper, sections III-B b) and III-G; what each fault does, in ``docs/faults.md``.
"""

from array import array
from collections.abc import Callable, Iterator, Mapping, MutableSequence, Sequence
from dataclasses import dataclass, field
from operator import itemgetter
from typing import Any, Final, NamedTuple, TypeAlias

from mrsfi_runtime.kernel.state import State, no_memory
from mrsfi_runtime.model.fault_types import ELEMENTS, FaultType, Field, Mode
from mrsfi_runtime.model.faults import (
    LAST,
    Event,
    FaultPool,
    Specification,
    Target,
    TimedFault,
    Trigger,
    touched,
)
from mrsfi_runtime.model.mission import Mission


@dataclass(slots=True)
class InjectionState:
    """One property of one target under one fault, active for ``start <= tick <= finish``.

    ``affected`` is a number of ``Field``; ``is_random`` is 1 if the value is drawn. ``a``, ``b``,
    ``c`` are a position; or the bounds of a random number; or, for any other number, an offset
    and a factor of the true one. A delay of ``n_held`` ticks keeps delayed values in a ring of
    ``Plan.held`` from ``first_held`` on, three entries per tick; 0 means that no value arrives in
    the window. ``kept_…`` is the value believed before this tick's delivery.
    """

    fault: int
    affected: int
    is_random: int
    target: int
    start: int
    finish: int
    a: float
    b: float
    c: float
    first_held: int
    n_held: int
    kept_a: float = 0.0
    kept_b: float = 0.0
    kept_c: float = 0.0


@dataclass(slots=True)
class OwnFault:
    """A fault of a user-defined type on one target, active for ``start <= tick <= finish``.

    ``target`` is the index of a robot, a sensor or an obstacle. ``values`` are those of the
    fault's parameters, ``age`` the ticks since its start, ``memory`` numbers that are 0 at its
    start. ``fault`` and ``effect`` are the numbers of the fault and its effect, ``kind`` that of
    the target's kind.
    """

    fault: int
    effect: int
    kind: int
    target: int
    start: int
    finish: int
    values: MutableSequence[float]
    age: int = 0
    memory: MutableSequence[float] = field(default_factory=no_memory)


@dataclass(slots=True)
class TriggerState:
    """An event that faults wait for; ``fired`` is the tick at whose end it first happened, or -1.

    ``event`` is a number of ``Event``. ``of`` is the index of a goal, or of a robot that enters the
    area of ``x``, ``y``, ``radius`` and corners, as in an ``AreaState``; or -1 for the effect of
    timed faults, which are ``n_sources`` numbers in ``Plan.sources`` from ``first_source`` on.
    """

    event: int
    of: int
    x: float
    y: float
    radius: float
    first_corner: int
    n_corners: int
    first_source: int
    n_sources: int
    delay: int
    fired: int = -1


@dataclass(slots=True)
class WaitingState:
    """An injection that is inactive until its trigger fires.

    It is the entry ``place`` of a list of the plan, whose number is ``listed``: ``messages``,
    ``reports``, ``commands``, ``own``. Then it is active within ``start … finish``, for at most
    ``most`` ticks.
    """

    trigger: int
    listed: int
    place: int
    start: int
    finish: int
    most: int


OwnEffect: TypeAlias = Callable[[State, State, OwnFault], None]
"""Changes the local state, the first argument; the second holds the newest messages."""


@dataclass(slots=True)
class FaultTally:
    """Numbers of ticks at which a timed fault was active, and at which it changed a value.

    ``first_changed`` and ``last_…`` are ticks, -1 if there is none yet.
    """

    applied: int = 0
    changed: int = 0
    last_applied: int = -1
    last_changed: int = -1
    first_changed: int = -1


@dataclass(slots=True)
class Plan:
    """All injections of one fault specification in lists by their kind, each sorted by start.

    ``messages`` delay and block messages, ``reports`` falsify beliefs, ``commands`` forge commands,
    and ``own`` are of user-defined types. ``held`` is the buffer of delayed messages; ``tallies``
    has one entry for each timed fault. If any faults wait, ``triggers`` are those of the pool, and
    ``waiting`` the injections that they activate; until then their ``finish`` is -1.
    """

    messages: list[InjectionState]
    reports: list[InjectionState]
    commands: list[InjectionState]
    held: list[float]
    tallies: list[FaultTally]
    own: list[OwnFault]
    triggers: list[TriggerState]
    waiting: list[WaitingState]
    sources: list[int]


InjectionRow: TypeAlias = tuple[int, int, int, int, int, int, float, float, float, int, int]
OwnRow: TypeAlias = tuple[int, int, int, int, int, int, MutableSequence[float]]

_START: Final = 4
_FINISH: Final = 5  # positions of the first and the last active tick in a row
_ABSENT: Final = ((0.0, 0.0, 0.0), (0.0, 0.0), (0.0,), ())  # by the number of values


class PlanRows(NamedTuple):
    """A plan as rows: messages, reports and commands, and own faults, each list sorted by start.

    ``n_held`` is the size of the buffer for delays, ``n_faults`` the number of timed faults.
    ``triggers``, ``waiting`` and ``sources`` are empty unless a fault waits. A row has the first
    attributes of its record.
    """

    lists: tuple[list[InjectionRow], list[InjectionRow], list[InjectionRow]]
    own: list[OwnRow]
    n_held: int
    n_faults: int
    triggers: Sequence[tuple[int, int, float, float, float, int, int, int, int, int]] = ()
    waiting: Sequence[tuple[int, int, int, int, int, int]] = ()
    sources: Sequence[int] = ()


class FaultShape(NamedTuple):
    """The properties that all timed faults of one fault of the pool share.

    ``change`` converts the fault's values, ``None`` if they stay. ``places`` has for each of
    ``targets`` the index of its list in ``PlanRows.lists``, its property, and its target.
    """

    kind: FaultType
    change: Callable[..., tuple[float, ...]] | None
    is_random: int
    is_held_back: bool
    targets: tuple[Target, ...]
    places: tuple[tuple[int, int, int], ...]


class FaultShapes(dict[str, FaultShape]):
    """Shapes of the faults of one mission and pool by ID, each computed at first use."""

    def __init__(self, mission: Mission, pool: FaultPool) -> None:
        super().__init__()
        self.last = mission.duration - 1
        self.mission = mission
        self.pool = pool

    def __missing__(self, fault_id: str) -> FaultShape:
        fault = self.pool[fault_id]
        targets = touched(self.mission, fault)
        mode = fault.kind.mode
        is_held_back = mode in {Mode.DELAY, Mode.BLOCK}
        forged = (Field.MOTION, Field.ACTIVATION)
        places = tuple(
            (0 if is_held_back else 2 if affected in forged else 1, int(affected), target)
            for affected, target in targets
        )
        is_random = int(mode is Mode.RANDOM)
        self[fault_id] = found = FaultShape(
            fault.kind, _CHANGES.get(mode), is_random, is_held_back, targets, places
        )
        return found


def plan(mission: Mission, pool: FaultPool, specification: Specification) -> Plan:
    """Return the plan of a fault specification that the gate admitted."""
    rows = plan_rows(FaultShapes(mission, pool), specification)
    messages, reports, commands = ([InjectionState(*row) for row in some] for some in rows.lists)
    return Plan(
        messages,
        reports,
        commands,
        [0.0] * rows.n_held,
        [FaultTally() for _ in range(rows.n_faults)],
        [OwnFault(*row) for row in rows.own],
        [TriggerState(*row) for row in rows.triggers],
        [WaitingState(*row) for row in rows.waiting],
        [*rows.sources],
    )


def plan_rows(shapes: FaultShapes, specification: Specification) -> PlanRows:
    """Return the plan of a fault specification as rows."""
    lists: tuple[list[InjectionRow], list[InjectionRow], list[InjectionRow]] = ([], [], [])
    own: list[OwnRow] = []
    n_held, waits = 0, False
    for number, timed in enumerate(specification):
        fault, start, finish, values, trigger = timed
        waits |= trigger != ""
        kind, change, is_random, is_held_back, targets, places = shapes[fault]
        if kind.effect >= 0:  # user-defined
            own += _own_rows(number, timed, kind, targets)
            continue
        if change is not None:
            values = change(*values)
        a, b, c = values + _ABSENT[len(values)]
        delay = 0
        if is_held_back:
            finish, delay = _held_back(timed, kind.mode, shapes.last)
        for place, affected, target in places:
            lists[place].append(
                (number, affected, is_random, target, start, finish, a, b, c, n_held, delay)
            )
            n_held += 3 * delay
    for listed in (*lists, own):
        listed.sort(key=itemgetter(_START))
    rows = PlanRows(lists, own, n_held, len(specification))
    return _waiting(shapes, specification, rows) if waits else rows


def _waiting(shapes: FaultShapes, specification: Specification, rows: PlanRows) -> PlanRows:
    numbers = {trigger: number for number, trigger in enumerate(shapes.pool.triggers_by_id)}
    triggers = []
    sources: list[int] = []
    for trigger in shapes.pool.triggers:
        event = int(trigger.event), *_happens(shapes.mission, trigger)
        found = [
            n for n, timed in enumerate(specification) if event[1] < 0 and timed.fault in trigger.of
        ]
        triggers.append((*event, len(sources), len(found), trigger.delay))
        sources += found
    waiting = []
    lists: tuple[list[Any], ...] = (*rows.lists, rows.own)
    for number, listed in enumerate(lists):
        for place, row in enumerate(listed):
            fault, start, finish, values, trigger_id = specification[row[0]]
            if not trigger_id:
                continue
            kind = shapes[fault].kind
            finish = finish if kind.mode is Mode.BLOCK else row[_FINISH]
            most = longest(kind, values, shapes.pool.triggers_by_id[trigger_id])
            waiting.append((numbers[trigger_id], number, place, start, finish, most))
            listed[place] = (*row[:_FINISH], -1, *row[_FINISH + 1 :])
    return rows._replace(triggers=triggers, waiting=waiting, sources=sources)


def longest(kind: FaultType, values: Sequence[float], trigger: Trigger) -> int:
    """Return for how many ticks at most a triggered fault is active."""
    most = LAST if trigger.duration is None else trigger.duration
    return min(most, int(values[0])) if kind.mode is Mode.BLOCK else most


def _happens(mission: Mission, trigger: Trigger) -> tuple[int, float, float, float, int, int]:
    """Return the index of an event's goal or robot, -1 for faults, and the area entered."""
    if trigger.event is Event.EFFECT:
        return -1, 0.0, 0.0, 0.0, 0, 0
    (of,) = trigger.of
    area = trigger.area
    if area is None:
        return mission.goal_ids.index(of), 0.0, 0.0, 0.0, 0, 0
    first = mission.polygons[area] if area.corners else 0
    robot, center = mission.robot_index[of], area.center
    return robot, center.x, center.y, area.radius, first, len(area.corners)


def active_window(shapes: FaultShapes, timed: TimedFault) -> tuple[int, int] | None:
    """Return the first and the last tick at which a fault is active; ``None`` if it never is.

    They are those of its window, except that blocks may end earlier, that delays of 0 ticks and
    properties without a message are never active, and that nothing is active after the mission. A
    fault with a trigger may be active between them, from the second tick on.
    """
    rows = plan_rows(shapes, (timed,))
    lists: tuple[list[Any], ...] = (*rows.lists, rows.own)
    windows = [(row[_START], row[_FINISH]) for listed in lists for row in listed]
    if rows.waiting:
        windows = [(max(start, 1), finish) for *_, start, finish, _ in rows.waiting]
    first, finish = next(iter(windows), (0, -1))
    last = min(finish, shapes.last)
    return (first, last) if first <= last else None


_CHANGES: Mapping[Mode, Callable[..., tuple[float, ...]]] = {
    Mode.INCREMENT: lambda step: (step, 1.0),
    Mode.DECREMENT: lambda step: (-step, 1.0),
    Mode.INCREMENT_PERCENT: lambda percent: (0.0, 1.0 + percent / 100.0),
    Mode.DECREMENT_PERCENT: lambda percent: (0.0, 1.0 - percent / 100.0),
    Mode.START: lambda: (0.0, 1.0),
    Mode.ACTIVATE: lambda: (1.0,),
}
"""Conversion of a fault's values to an offset and a factor of the true number.

The values of other modes need none: a fixed value has factor 0, and zero has offset and factor 0.
"""


def _held_back(timed: TimedFault, mode: Mode, last: int) -> tuple[int, int]:
    """Return the last tick of a fault, and the delay of messages that arrive before it, in ticks.

    A delay of 0 ticks is never active; no message arrives after the mission's last tick.
    """
    ticks = int(timed.values[0])
    if mode is Mode.BLOCK:
        return min(timed.finish, timed.start + ticks - 1), 0
    if ticks < 1:
        return timed.start - 1, 0
    return timed.finish, ticks if ticks <= min(timed.finish, last) - timed.start else 0


def _own_rows(
    number: int, timed: TimedFault, kind: FaultType, targets: Sequence[Target]
) -> Iterator[OwnRow]:
    """Yield a row for each target of which the fault affects all properties of its type."""
    values = no_memory()
    values[: len(timed.values)] = array("d", timed.values)
    for target in dict.fromkeys(index for _, index in targets):
        if all((affected, target) in targets for affected in kind.properties):
            of = _ELEMENTS[kind.properties[0]]
            yield number, kind.effect, of, target, timed.start, timed.finish, values


_ELEMENTS = {affected: of for of, properties in enumerate(ELEMENTS) for affected in properties}

OF_SENSOR = _ELEMENTS[Field.COUNT]
OF_OBSTACLE = _ELEMENTS[Field.OBSTACLE]
"""Target kinds of a user-defined fault, if not a robot: ``OwnFault.kind``."""

POSITION, SPEED, ENERGY, COUNT, RATE, COST, OBSTACLE, MOTION, ACTIVATION = map(int, Field)
