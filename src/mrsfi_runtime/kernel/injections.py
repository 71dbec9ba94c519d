"""Faults laid out for the kernel: each timed fault as injections, one per property it touches.

``plan_rows`` lays a fault specification out as rows, which a compiled engine copies into arrays;
``plan`` makes records of them. Each list is sorted by start, so that a tick reads no further than
to the first injection that begins later. Faults that wait for a trigger stand in these lists with
a ``finish`` of -1, and in ``waiting`` with what they do once they are set off.

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

    ``affected`` is a number of ``Field``. ``is_random`` says whether chance decides on the value.
    ``a``, ``b``, ``c`` are a place; or the bounds between which a random number lies; or, of any
    other number, what is added, and to what share of the true one. A delay of ``n_held`` ticks
    keeps what is under way in a ring of ``Plan.held`` from ``first_held`` on, three entries a
    tick; 0 means that nothing arrives in the window. ``kept_…`` is what was believed before this
    tick's delivery.
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
    values: MutableSequence[float]
    age: int = 0
    memory: MutableSequence[float] = field(default_factory=no_memory)


@dataclass(slots=True)
class TriggerState:
    """What faults wait for, and at the end of which tick it was first so; -1: not yet.

    ``event`` is a number of ``Event``, ``of`` the index of a goal, or of a robot that enters the
    area of ``x``, ``y`` and ``radius``, or -1; its faults are timed ones, ``n_sources`` numbers of
    ``Plan.sources`` from ``first_source`` on.
    """

    event: int
    of: int
    x: float
    y: float
    radius: float
    first_source: int
    n_sources: int
    delay: int
    fired: int = -1


@dataclass(slots=True)
class WaitingState:
    """An injection that is active at no tick until its trigger sets it off.

    It stands at ``place`` of a list of the plan: ``messages``, ``reports``, ``commands``, ``own``
    by ``listed``. Then it is active from within ``start … finish``, ``most`` ticks at most.
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
    """At how many ticks a timed fault was active, and at how many it changed a value.

    ``first_changed`` and ``last_…`` are ticks, -1 while there was none.
    """

    applied: int = 0
    changed: int = 0
    last_applied: int = -1
    last_changed: int = -1
    first_changed: int = -1


@dataclass(slots=True)
class Plan:
    """All injections of one fault specification, by what they act on, each list by start.

    ``messages`` are delayed and blocked ones, ``reports`` falsify what is believed,
    ``commands`` are forged, ``own`` are those of a team's own types. ``held`` is room for delayed
    messages; ``tallies`` has one entry for each timed fault. If any faults wait, ``triggers`` are
    those of the pool, and ``waiting`` what they set off; until then its ``finish`` is -1.
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
_FINISH: Final = 5  # where a row has the first and the last tick at which it is active


class PlanRows(NamedTuple):
    """A plan before its run: messages, reports and commands, and own faults, each list by start.

    ``n_held`` are the numbers that delays hold back, ``n_faults`` the timed faults. Triggers, what
    waits for them, and faults whose effects they are, only if anything waits. A row has the first
    attributes of its record.
    """

    lists: tuple[list[InjectionRow], list[InjectionRow], list[InjectionRow]]
    own: list[OwnRow]
    n_held: int
    n_faults: int
    triggers: Sequence[tuple[int, int, float, float, float, int, int, int]] = ()
    waiting: Sequence[tuple[int, int, int, int, int, int]] = ()
    sources: Sequence[int] = ()


class FaultShape(NamedTuple):
    """What all timed faults of a pool's fault have in common.

    ``change`` is what its values become, ``None`` if they stay; ``places`` has for each of
    ``targets`` the place of its list in ``PlanRows.lists``, property, and target.
    """

    kind: FaultType
    change: Callable[..., tuple[float, ...]] | None
    is_random: int
    is_held_back: bool
    targets: tuple[Target, ...]
    places: tuple[tuple[int, int, int], ...]


class FaultShapes(dict[str, FaultShape]):
    """Shapes of the faults of one mission and pool by ID, each found when it is first asked for."""

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
    """Lay a fault specification that the gate admitted out for the kernel."""
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
    """Lay a fault specification out as rows; as ``plan``."""
    lists: tuple[list[InjectionRow], list[InjectionRow], list[InjectionRow]] = ([], [], [])
    own: list[OwnRow] = []
    n_held = 0
    for number, timed in enumerate(specification):
        fault, start, finish, values, _ = timed
        kind, change, is_random, is_held_back, targets, places = shapes[fault]
        if kind.mode is Mode.OWN:
            own += _own_rows(number, timed, kind, targets)
            continue
        values = values if change is None else change(*values)
        a, b, c = (*map(float, values), 0.0, 0.0, 0.0)[:3]
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
    return (
        _waiting(shapes, specification, rows)
        if any(timed.trigger for timed in specification)
        else rows
    )


def _waiting(shapes: FaultShapes, specification: Specification, rows: PlanRows) -> PlanRows:
    numbers = {trigger: number for number, trigger in enumerate(shapes.pool.triggers_by_id)}
    triggers = []
    sources: list[int] = []
    for trigger in shapes.pool.triggers:
        of, x, y, radius = _happens(shapes.mission, trigger)
        found = [n for n, timed in enumerate(specification) if of < 0 and timed.fault in trigger.of]
        triggers.append(
            (int(trigger.event), of, x, y, radius, len(sources), len(found), trigger.delay)
        )
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
    """Return for how many ticks a fault acts at most that a trigger has set off."""
    most = LAST if trigger.duration is None else trigger.duration
    return min(most, int(values[0])) if kind.mode is Mode.BLOCK else most


def _happens(mission: Mission, trigger: Trigger) -> tuple[int, float, float, float]:
    """Return the goal or robot that an event happens to, -1 for faults, and the area entered."""
    if trigger.event is Event.EFFECT:
        return -1, 0.0, 0.0, 0.0
    (of,) = trigger.of
    if trigger.area is None:
        return mission.goal_ids.index(of), 0.0, 0.0, 0.0
    center = trigger.area.center
    return mission.robot_index[of], center.x, center.y, trigger.area.radius


def active_window(mission: Mission, pool: FaultPool, timed: TimedFault) -> tuple[int, int] | None:
    """Return the first and the last tick at which a fault is active; ``None`` if it never is.

    They are those of its window, but for blocks that end before it, for delays of no tick, for
    what no message carries, and for what lies behind the mission's end. One with a trigger may be
    active between them, from the second tick on.
    """
    rows = plan_rows(FaultShapes(mission, pool), (timed,))
    lists: tuple[list[Any], ...] = (*rows.lists, rows.own)
    windows = [(row[_START], row[_FINISH]) for listed in lists for row in listed]
    if rows.waiting:
        windows = [(max(start, 1), finish) for *_, start, finish, _ in rows.waiting]
    for first, finish in windows:
        last = min(finish, mission.duration - 1)
        return (first, last) if first <= last else None
    return None


_CHANGES: Mapping[Mode, Callable[..., tuple[float, ...]]] = {
    Mode.INCREMENT: lambda step: (step, 1.0),
    Mode.DECREMENT: lambda step: (-step, 1.0),
    Mode.INCREMENT_PERCENT: lambda percent: (0.0, 1.0 + percent / 100.0),
    Mode.DECREMENT_PERCENT: lambda percent: (0.0, 1.0 - percent / 100.0),
    Mode.START: lambda: (0.0, 1.0),
    Mode.ACTIVATE: lambda: (1.0,),
}
"""What the values of a fault become: what is added, and to what share of the true number.

Those of the other modes are so already: a fixed value is added to nothing, and zero is nothing.
"""


def _held_back(timed: TimedFault, mode: Mode, last: int) -> tuple[int, int]:
    """Return when a fault ends, and by how many ticks messages are late that arrive before.

    A delay of no tick never becomes active; nothing arrives after the mission's last tick.
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
    """Yield a row for each target of which all is touched that the fault's type names."""
    values = no_memory()
    values[: len(timed.values)] = array("d", timed.values)
    for target in dict.fromkeys(index for _, index in targets):
        if all((affected, target) in targets for affected in kind.properties):
            of = _ELEMENTS[kind.properties[0]]
            yield number, kind.effect, of, target, timed.start, timed.finish, values


_ELEMENTS = {affected: of for of, properties in enumerate(ELEMENTS) for affected in properties}

OF_SENSOR = _ELEMENTS[Field.COUNT]
OF_OBSTACLE = _ELEMENTS[Field.OBSTACLE]
"""On what a fault of a team's own type acts, if on no robot: ``OwnFault.kind``."""

POSITION, SPEED, ENERGY, COUNT, RATE, COST, OBSTACLE, MOTION, ACTIVATION = map(int, Field)
