"""Faults, the properties they touch, and the gate that each fault specification passes.

A ``FaultPool`` has the faults that could occur in a mission. Search combines them into a
specification: ``TimedFault`` values, each with its window and values. Two faults conflict when they
touch the same property of the same target (``touched``), because one would disable the other.

The invariant: every specification passes ``Gate.admitted``, whether it comes from models, scripts,
search, users' code or records. After it, conflicting faults never overlap, and numbers are Python's
own types. Windows and whole values fit an ``EInt``, other values are at most ``MOST``; within these
limits the reference and the compiled engine agree to the last bit.

``value_bounds`` returns the values among which search may choose. The model's bounds come first,
then defaults for the parameter's range in the mission. The pool's value always lies inside.

Begin with ``Fault``, ``TimedFault`` and ``Gate``.

References
----------
Source paper, sections III-B b), III-C b) and III-E a) to c). It defines conflicts by *same message*
in one place and by *same class* in another; the key used here serves the purpose that it states.
It does not define the bounds of values.
"""

import math
from collections import defaultdict
from collections.abc import Callable, Collection, Container, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from enum import IntEnum
from functools import cached_property
from itertools import count
from numbers import Integral, Real
from operator import itemgetter
from typing import Any, NamedTuple, Self, TypeAlias

from mrsfi_runtime.errors import SpecificationError, counted, expected
from mrsfi_runtime.model.fault_types import (
    IN_NO_MESSAGE,
    OF_ROBOT,
    OF_SENSOR,
    FaultType,
    Field,
    Mode,
    Parameter,
    Range,
    Struck,
    Units,
)
from mrsfi_runtime.model.mission import Area, Mission, Obstacle, Robot, Sensor

OwnValue: TypeAlias = "str | float | Mapping[str, OwnValue] | tuple[OwnValue, ...] | None"
"""Value of a user-defined feature of a metamodel; a mapping is a contained element."""


class Event(IntEnum):
    """What can trigger faults, judged in truth at the end of a tick."""

    VIOLATED = 0  # a goal is violated
    REACHED = 1  # a goal has all its samples, or its robots have reached their destination
    ENTERED = 2  # a robot is in an area
    EFFECT = 3  # a fault has changed something


@dataclass(frozen=True, slots=True)
class Trigger:
    """An event that activates faults when it first happens in a flight.

    ``of`` has IDs: of a goal, of a robot that enters the ``area``, or of faults, any of which
    suffices. A fault that waits for it is active ``delay`` ticks after the following tick, for
    ``duration`` ticks at most; ``None`` is to the end of its window.
    """

    id: str
    event: Event
    of: tuple[str, ...]
    area: Area | None = None
    delay: int = 0
    duration: int | None = None

    @property
    def words(self) -> str:
        """When waiting faults are active: ``when g4 is reached, 5 ticks later, for 9 ticks``."""
        lasts = "" if self.duration is None else f", for {counted(self.duration, 'ticks')}"
        return self.when + lasts

    @property
    def when(self) -> str:
        """When waiting faults begin: ``when g4 is reached, 5 ticks later``."""
        area = self.area.id if self.area else "no area"
        happens = ("is violated", "is reached", f"enters {area}", "changes something")[self.event]
        later = f", {counted(self.delay, 'ticks')} later" if self.delay else ""
        return f"when {' or '.join(self.of) or 'nothing'} {happens}{later}"


@dataclass(frozen=True, slots=True)
class Fault:
    """A fault of the pool.

    ``target`` is the ID of a message, robot, sensor or obstacle, as ``kind.struck`` says.
    ``values`` follow ``kind.parameters``. ``bounds`` has the model's bounds of evolving parameters
    by name: (lowest, highest), ``None`` where the model has none. ``start``, ``finish`` and the ID
    of a ``trigger`` are set in a written fault specification, not in a pool. ``likelihood`` is the
    chance that the fault occurs in a mission, 0 … 1, ``None`` if unknown. ``reference`` is the ID
    of its failure mode in a document of the team. ``own`` has user-defined features of the class of
    faults, or of their type.
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
    reference: str = ""

    @property
    def type(self) -> str:
        """Name of the fault's type."""
        return self.kind.name

    @property
    def words(self) -> str:
        """Its type and target: ``FixedSpeed of m8``."""
        return f"{self.type} of {self.target}"


class TimedFault(NamedTuple):
    """A pool fault that is active for ``start <= tick <= finish``.

    ``fault`` is the ID of the pool fault; ``values`` replace those of the pool. With a ``trigger``,
    given by its ID, the fault is active in that window only after the trigger.
    """

    fault: str
    start: int
    finish: int
    values: tuple[float, ...] = ()
    trigger: str = ""


Specification: TypeAlias = tuple[TimedFault, ...]
"""A fault specification: the timed faults of one run, no two conflicting ones overlapping."""


_NONE = TimedFault("", -1, -1)


def numbered(faults: Iterable[str]) -> tuple[str, ...]:
    """Return a name for each timed fault, by pool faults: ``f9.1``, ``f9.2`` for two of ``f9``."""
    numbers: dict[str, count[int]] = defaultdict(lambda: count(1))
    return tuple(f"{fault}.{next(numbers[fault])}" for fault in faults)


def original(name: str, faults: Container[str]) -> str:
    """Return the fault that a name stands for; a name with a number stands for a copy."""
    base, _, number = name.rpartition(".")
    return base if base and name not in faults and number.isdecimal() else name


def fault_ticks(specification: Specification, duration: int) -> int:
    """Return the ticks of a mission at which faults are active, summed over timed faults."""
    return sum(max(0, min(timed.finish + 1, duration) - timed.start) for timed in specification)


COSTS: Mapping[str, Callable[[Specification, int], int]] = {
    "faults": lambda specification, _: len(specification),
    "fault_ticks": fault_ticks,
}
"""Costs that a search can minimise, of a specification and a mission's duration in ticks."""


@dataclass(frozen=True)
class FaultPool:
    """The faults that could occur in a mission, and their triggers, in model order."""

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

    def with_prefix(self, prefix: str) -> Self:
        """Return the pool with a prefix before the IDs of its faults and triggers."""

        def named(identifier: str) -> str:
            return identifier and prefix + identifier

        faults = (replace(each, id=named(each.id), trigger=named(each.trigger)) for each in self)
        triggers = (
            replace(
                each,
                id=named(each.id),
                of=tuple(map(named, each.of)) if each.event is Event.EFFECT else each.of,
            )
            for each in self.triggers
        )
        return replace(self, faults=tuple(faults), triggers=tuple(triggers))

    def written_specification(self) -> Specification:
        """Return the faults of a written specification; each must have a window."""
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


Target: TypeAlias = tuple[Field, int]
"""A property and the index of the robot, sensor or obstacle that has it."""

_OF_ANY_SENSOR = (*OF_SENSOR, Field.ACTIVATION)

_BY_NAME = {affected.name: affected for affected in OF_ROBOT}
"""Properties by entry of a message's body; all other entries are types of sensors."""


def touched(mission: Mission, fault: Fault) -> tuple[Target, ...]:
    """Return the properties that a fault touches, in model order; none if no message carries them.

    An unknown element is a ``SpecificationError``.
    """
    key = (fault.type, fault.target)
    if key not in mission.touches:
        mission.touches[key] = tuple(dict.fromkeys(_targets(mission, fault)))
    return mission.touches[key]


def robots_of(mission: Mission, targets: Iterable[Target]) -> frozenset[int]:
    """Return the indices of the robots that have the properties, or carry the sensors that do."""
    return frozenset(
        mission.sensor_robot[index] if affected in _OF_ANY_SENSOR else index
        for affected, index in targets
        if affected is not Field.OBSTACLE
    )


def elements_of(mission: Mission, fault: Fault) -> frozenset[str]:
    """Return the IDs of what a fault strikes, and of the robots that it touches."""
    robots = robots_of(mission, touched(mission, fault))
    return frozenset((fault.target, *(mission.robots[index].id for index in robots)))


def unprotected(mission: Mission, pool: FaultPool, elements: Collection[str]) -> FaultPool:
    """Return a pool without the faults of some elements, and triggers of these faults alone."""
    if not elements:
        return pool
    left_out = {fault.id for fault in pool if not elements_of(mission, fault).isdisjoint(elements)}
    triggers = (
        each
        for each in pool.triggers
        if each.event is not Event.EFFECT or not left_out.issuperset(each.of)
    )
    return replace(pool.without(left_out), triggers=tuple(triggers))


def describe(mission: Mission, target: Target) -> str:
    """Return a target in words, for example ``r3 energy`` or ``s4 count``."""
    affected, index = target
    owners: Sequence[Robot | Sensor | Obstacle] = mission.robots
    if affected in _OF_ANY_SENSOR:
        owners = mission.sensors
    elif affected is Field.OBSTACLE:
        owners = mission.obstacles
    return f"{owners[index].id} {affected.name.lower()}"


def _targets(mission: Mission, fault: Fault) -> tuple[Target, ...]:
    kind = fault.kind
    try:
        match kind.struck:
            case Struck.MESSAGE:
                return _touched_by_message(mission, fault)
            case Struck.ROBOT:
                return tuple(_of_robot(mission, mission.robot_index[fault.target], kind.properties))
            case Struck.SENSOR:
                index = mission.sensor_index[fault.target]
            case Struck.OBSTACLE:
                index = mission.obstacle_index[fault.target]
        return tuple((affected, index) for affected in kind.properties)
    except KeyError as error:
        raise SpecificationError(
            f"fault '{fault.id}' ({fault.type}) refers to {error.args[0]!r}; "
            f"the mission has no such {kind.struck.value}"
        ) from None


def _of_robot(mission: Mission, robot: int, properties: Iterable[Field]) -> Iterator[Target]:
    sensors = [mission.sensor_index[sensor.id] for sensor in mission.robots[robot].sensors]
    for affected in properties:
        if affected in OF_SENSOR:
            yield from ((affected, index) for index in sensors)
        else:
            yield affected, robot


def _touched_by_message(mission: Mission, fault: Fault) -> tuple[Target, ...]:
    message, goal = mission.message_goal[fault.target]
    if message.sender not in mission.robot_index:  # a server reports nothing of its own
        return ()
    robot = mission.robot_index[message.sender]
    wanted, sensors = fault.kind.properties, mission.robots[robot].sensors
    carried: list[Target] = []
    for entry in message.body:
        if entry.name in _BY_NAME:
            carried.append((_BY_NAME[entry.name], robot))
        else:
            found = [mission.sensor_index[each.id] for each in sensors if each.type == entry.name]
            carried += [(Field.COUNT, index) for index in found]
    about = [each.id for each in sensors]
    if goal.terms.sensor in about:
        about = [goal.terms.sensor]
    silent = [affected for affected in wanted if affected in IN_NO_MESSAGE]
    return (
        *(target for target in carried if not wanted or target[0] in wanted),
        *((affected, mission.sensor_index[each]) for affected in silent for each in about),
    )


MOST = 1e12  # the largest magnitude of a value
LAST = 2**31 - 1  # the largest tick of a window, and the largest whole value


def plain(timed: TimedFault) -> TimedFault:
    """Return a timed fault in Python's own numbers, values as floats; refuse what is not one."""
    if _are_plain((timed,)):
        return timed
    try:
        fault, start, finish, values, *more = timed
        values, (trigger,) = tuple(values), more or [""]
    except (TypeError, ValueError):
        wanted = "a timed fault: its ID, start, finish, values, and its trigger if it has one"
        raise SpecificationError(f"found {timed!r}; expected {wanted}") from None
    for name, found in (("fault", fault), ("trigger", trigger)):
        if not isinstance(found, str):
            raise SpecificationError(f"found {name} {found!r}; expected its ID, as text")
    if not _are(Integral, start, finish) or not 0 <= start <= finish <= LAST:
        wanted = f"whole numbers, 0 <= start <= finish <= {LAST}"
        raise _misfit(fault, f"window {start!r} … {finish!r}", wanted)
    if not _are(Real, *values) or not all(-MOST <= value <= MOST for value in values):
        raise _misfit(fault, f"values {values!r}", f"numbers from {-MOST:.0f} to {MOST:.0f}")
    return TimedFault(str(fault), int(start), int(finish), tuple(map(float, values)), str(trigger))


def _are_plain(specification: Iterable[TimedFault]) -> bool:
    """Return quickly whether nothing has to change; search has millions of timed faults."""
    for timed in specification:
        if type(timed) is not TimedFault:
            return False
        fault, start, finish, values, trigger = timed
        if not (type(start) is type(finish) is int and type(fault) is type(trigger) is str):
            return False
        if type(values) is not tuple or not 0 <= start <= finish <= LAST:
            return False
        for value in values:
            if type(value) is not float or not -MOST <= value <= MOST:
                return False
    return True


def _are(kind: type[Any], *found: object) -> bool:
    """Return whether all are numbers of a kind; Booleans and text are not."""
    return all(isinstance(each, kind) and not isinstance(each, bool) for each in found)


def _misfit(fault: str, found: str, wanted: str) -> SpecificationError:
    return SpecificationError(f"fault '{fault}' has {found}; expected {wanted}", (fault,))


def timed_fault(
    fault: str, kind: FaultType, start: int, finish: int, values: Mapping[str, float]
) -> TimedFault:
    """Return a timed fault of a type, its values given by parameter; refuse what does not fit."""
    names = [parameter.name for parameter in kind.parameters]
    for name in values:
        if name not in names:
            what = f"fault '{fault}' ({kind.name}) has no parameter '{name}'"
            raise SpecificationError(f"{what}; {expected(name, names)}", (fault,))
    timed = TimedFault(fault, start, finish, tuple(values[name] for name in names))
    return fitting(kind, plain(timed))


def limits(parameter: Parameter) -> tuple[float, float]:
    """Return the lowest and the highest value that a parameter may ever have."""
    if parameter.is_integer:
        return 0.0 if parameter.range is Range.TICKS else -LAST - 1.0, float(LAST)
    return -MOST, MOST


def fitting(kind: FaultType, timed: TimedFault) -> TimedFault:
    """Return a plain timed fault whose values fit its type; refuse others."""
    parameters, values = kind.parameters, timed.values
    if len(values) != len(parameters):
        names = ", ".join(parameter.name for parameter in parameters) or "it takes none"
        raise _misfit(timed.fault, f"{len(values)} values", f"{len(parameters)} values ({names})")
    for parameter, value in zip(parameters, values, strict=True):
        if parameter.is_integer and not (
            value.is_integer() and (0.0 <= value <= LAST or limits(parameter)[0] <= value < 0.0)
        ):
            wanted = "a whole number from {:.0f} to {:.0f}".format(*limits(parameter))
            raise _misfit(timed.fault, f"{parameter.name} {value}", wanted)
    if len(values) > 1 and values[0] > values[1] and kind.mode is Mode.RANDOM:
        raise _misfit(timed.fault, kind.in_words(values, Units()), "the lower one first")
    return timed


class Admission(NamedTuple):
    """What a gate checks of a timed fault, by its fault of the pool.

    ``wholes`` are the places of whole numbers among ``n_values``; ``is_range`` is whether the first
    must not exceed the second. No other fault may touch one of the ``keys`` at the same time: its
    targets, or itself.
    """

    kind: FaultType
    n_values: int
    wholes: tuple[int, ...]
    is_range: bool
    keys: tuple[Target | str, ...]


class Gate(dict[str, Admission]):
    """Admits fault specifications to one mission and pool, and caches what it checks, by fault.

    Faults of a written specification may be copies of ``originals``, by ID.
    """

    def __init__(
        self, mission: Mission, pool: FaultPool, originals: Container[str] | None = None
    ) -> None:
        super().__init__()
        self.mission = mission
        self.pool = pool
        self._originals = pool.by_id if originals is None else originals

    def __missing__(self, fault_id: str) -> Admission:
        fault = self.pool[fault_id]
        itself = f"{original(fault_id, self._originals)}: {fault.words}"
        kind, parameters = fault.kind, fault.kind.parameters
        wholes = tuple(place for place, each in enumerate(parameters) if each.is_integer)
        is_range = kind.mode is Mode.RANDOM and len(parameters) > 1
        keys: tuple[Target | str, ...] = touched(self.mission, fault) or (itself,)
        self[fault_id] = found = Admission(kind, len(parameters), wholes, is_range, keys)
        return found

    def admitted(self, specification: Iterable[TimedFault]) -> Specification:
        """Return a specification in Python's own numbers.

        Unknown faults, triggers and elements, invalid windows and values, and conflicting faults
        that overlap are a ``SpecificationError``.
        """
        try:
            asked = tuple(specification)
        except TypeError:
            wanted = "timed faults, in a list or tuple"
            raise SpecificationError(f"found {specification!r}; expected {wanted}") from None
        found = asked if _are_plain(asked) else tuple(map(plain, asked))
        self._require(sorted(found, key=itemgetter(1)))  # by start
        return found

    def _require(self, specification: Iterable[TimedFault]) -> None:
        """Refuse plain timed faults that do not fit; what does is not looked at for long."""
        newest: dict[Target | str, TimedFault] = {}
        for timed in specification:
            fault, start, _, values, trigger = timed
            kind, n_values, wholes, is_range, keys = self[fault]
            fits = len(values) == n_values and not (is_range and values[0] > values[1])
            for place in wholes if fits else ():
                fits &= 0.0 <= values[place] <= LAST and values[place].is_integer()
            if not fits:
                fitting(kind, timed)
            if trigger:
                self._require_trigger(timed)
            for key in keys:
                if newest.get(key, _NONE)[2] >= start:
                    raise self._overlap(newest[key], timed)
                newest[key] = timed

    def conflicts(self) -> Mapping[str, frozenset[str]]:
        """Return for every fault ID the IDs of the faults that it may not overlap, itself included.

        A fault that touches nothing conflicts only with itself.
        """
        keys = {fault.id: frozenset(self[fault.id].keys) for fault in self.pool}
        return {
            fault_id: frozenset(other for other, others in keys.items() if key & others)
            for fault_id, key in keys.items()
        }

    def _require_trigger(self, timed: TimedFault) -> None:
        """Refuse a trigger that is not in the pool, or whose elements are not in the mission."""
        known, mission = self.pool.triggers_by_id, self.mission
        what, found, there = "trigger", timed.trigger, tuple(known)
        if found in known and known[found].event is not Event.EFFECT:
            what = f"trigger '{found}', which is about"
            (found,) = known[found].of
            is_robot = known[timed.trigger].area is not None
            there = tuple(mission.robot_index) if is_robot else mission.goal_ids
        if found not in there:
            text = f"fault '{timed.fault}' has {what} '{found}'; {expected(found, there)}"
            raise SpecificationError(text, (timed.fault,))

    def _overlap(self, first: TimedFault, second: TimedFault) -> SpecificationError:
        others = {*self[second.fault].keys}
        keys = self[first.fault].keys
        shared = (key for key in keys if key in others and not isinstance(key, str))
        what = ", ".join(describe(self.mission, key) for key in shared) or "nothing"
        return SpecificationError(
            f"faults '{first.fault}' ({first.start} … {first.finish}) and '{second.fault}' "
            f"({second.start} … {second.finish}) overlap and both touch {what}; "
            "conflicting faults must not be active at the same tick",
            (first.fault, second.fault),
        )


def value_bounds(mission: Mission, fault: Fault) -> tuple[tuple[float, float], ...]:
    """Return the lowest and highest value of each parameter of a pool fault, in their order.

    A parameter that does not evolve has its pool value twice. The bounds of an integer parameter
    are the outermost whole numbers inside; if there is none, its pool value twice.
    """
    return tuple(
        _bounds(mission, fault, parameter, value)
        for parameter, value in zip(fault.kind.parameters, fault.values, strict=True)
    )


def _bounds(
    mission: Mission, fault: Fault, parameter: Parameter, value: float
) -> tuple[float, float]:
    if not parameter.evolves:
        return value, value
    least, most = limits(parameter)
    usual = _default_bounds(mission, fault, parameter.range)
    lowest, highest = (min(max(bound, least), most) for bound in usual)
    model_lowest, model_highest = fault.bounds.get(parameter.name, (None, None))
    low = min(lowest if model_lowest is None else model_lowest, value)
    high = max(highest if model_highest is None else model_highest, value)
    if parameter.is_integer:
        low, high = float(math.ceil(low)), float(math.floor(high))
        return (low, high) if low <= high else (value, value)
    return low, high


def _default_bounds(mission: Mission, fault: Fault, of: Range) -> tuple[float, float]:
    center, reach, duration = mission.area.center, 1.5 * mission.area.radius, mission.duration
    of_mission = {
        Range.TICKS: (1.0, float(duration)),
        Range.COUNT: (0.0, float(duration)),  # one valid sample a tick on average
        Range.PERCENT: (0.0, 100.0),
        Range.SHARE: (0.0, 1.0),
        Range.X: (center.x - reach, center.x + reach),
        Range.Y: (center.y - reach, center.y + reach),
        Range.Z: (center.z - reach, center.z + reach),
    }
    if of in of_mission:
        return of_mission[of]
    found = [target for target in touched(mission, fault) if target[0] in OF_SENSOR]
    robots = _robots(mission, fault)
    sensors = [mission.sensors[index] for _, index in found]
    sensors = sensors or [sensor for robot in robots for sensor in robot.sensors]
    largest = {
        Range.ENERGY: [robot.total_energy for robot in robots],
        Range.SPEED: [10.0 * robot.speed for robot in robots],  # ten times nominal
        Range.RATE: [10.0 * sensor.samples_per_second for sensor in sensors],
        Range.COST: [10.0 * sensor.energy_per_sample for sensor in sensors],
    }
    return 0.0, max(largest[of], default=0.0)


def _robots(mission: Mission, fault: Fault) -> tuple[Robot, ...]:
    """Return the robots that a fault touches: none for a server's message, all for an obstacle."""
    index: int | None
    match fault.kind.struck:
        case Struck.OBSTACLE:
            return mission.robots
        case Struck.MESSAGE:
            index = mission.robot_index.get(mission.message_goal[fault.target][0].sender)
        case Struck.ROBOT:
            index = mission.robot_index[fault.target]
        case Struck.SENSOR:
            index = mission.sensor_robot[mission.sensor_index[fault.target]]
    return () if index is None else (mission.robots[index],)
