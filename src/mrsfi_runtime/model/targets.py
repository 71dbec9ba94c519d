"""Which properties a fault touches, and which faults therefore conflict.

Two faults conflict when they touch the same property of the same target: one would
disable the other. Conflicting faults never overlap in one specification.

References
----------
Source paper, sections III-C b), III-E b) and c). The paper says *same message* in one
place and *same class* in another; this key serves the purpose it states.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from operator import attrgetter
from typing import TypeAlias

from mrsfi_runtime.errors import SpecificationError
from mrsfi_runtime.model.fault_types import (
    IN_NO_MESSAGE,
    OF_ROBOT,
    OF_SENSOR,
    Field,
    Struck,
)
from mrsfi_runtime.model.faults import Fault, FaultPool, Specification, TimedFault
from mrsfi_runtime.model.mission import Message, Mission, Obstacle, Robot, Sensor

Target: TypeAlias = tuple[Field, int]
"""A property and the index of the robot, sensor or obstacle that has it."""

_OF_ANY_SENSOR = (*OF_SENSOR, Field.ACTIVATION)

_BY_NAME = {affected.name: affected for affected in OF_ROBOT}
"""What the entries of a message's body stand for; all others are types of sensors."""


def touched(mission: Mission, fault: Fault) -> tuple[Target, ...]:
    """Return what a fault touches, each once, in model order; nothing if no message carries it.

    Raises
    ------
    SpecificationError
        If the fault refers to an element that the mission does not have.
    """
    key = (fault.type, fault.target)
    if key not in mission.touches:
        mission.touches[key] = tuple(dict.fromkeys(_found(mission, fault)))
    return mission.touches[key]


def robots_of(mission: Mission, targets: Iterable[Target]) -> frozenset[int]:
    """Return the indices of the robots that have the properties, or carry the sensors that do."""
    return frozenset(
        mission.sensor_robot[index] if affected in _OF_ANY_SENSOR else index
        for affected, index in targets
        if affected is not Field.OBSTACLE
    )


def describe(mission: Mission, target: Target) -> str:
    """Return a target in words, for example ``r3 energy`` or ``s4 count``."""
    affected, index = target
    owners: Sequence[Robot | Sensor | Obstacle] = mission.robots
    if affected in _OF_ANY_SENSOR:
        owners = mission.sensors
    elif affected is Field.OBSTACLE:
        owners = mission.obstacles
    return f"{owners[index].id} {affected.name.lower()}"


def _found(mission: Mission, fault: Fault) -> tuple[Target, ...]:
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
    """Yield properties of a robot, and of all its sensors."""
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
    wanted = fault.kind.properties
    carried = tuple(_carried(mission, robot, message))
    sensors = [sensor.id for sensor in mission.robots[robot].sensors]
    if goal.terms.sensor in sensors:
        sensors = [goal.terms.sensor]
    return (
        *(target for target in carried if not wanted or target[0] in wanted),
        *(
            (affected, mission.sensor_index[sensor])
            for affected in wanted
            if affected in IN_NO_MESSAGE
            for sensor in sensors
        ),
    )


def _carried(mission: Mission, robot: int, message: Message) -> Iterator[Target]:
    """Yield what a message of a robot carries, in the order of its body."""
    for entry in message.body:
        if entry.name in _BY_NAME:
            yield _BY_NAME[entry.name], robot
        else:
            for sensor in mission.robots[robot].sensors:
                if sensor.type == entry.name:
                    yield Field.COUNT, mission.sensor_index[sensor.id]


def conflicts(mission: Mission, pool: FaultPool) -> Mapping[str, frozenset[str]]:
    """Return for every fault ID the IDs of the faults that it may not overlap, itself included.

    A fault that touches nothing conflicts with itself only: twice at once would be pointless.
    """
    keys = {fault.id: frozenset(touched(mission, fault)) for fault in pool}
    return {
        fault_id: frozenset(
            other for other, others in keys.items() if other == fault_id or key & others
        )
        for fault_id, key in keys.items()
    }


def require_no_overlap(mission: Mission, pool: FaultPool, specification: Specification) -> None:
    """Refuse a specification in which conflicting faults overlap or a window makes no sense.

    Raises
    ------
    SpecificationError
        Naming both faults, their windows and what they both touch.
    """
    Exclusion(mission, pool).require(specification)


class Exclusion(dict[str, tuple[int, tuple[Target | str, ...]]]):
    """Refuses specifications of one mission and pool; what it finds out of faults, it remembers.

    By ID of a fault it has the number of its values, and what no other may touch at the same time:
    itself, and its targets.

    Parameters
    ----------
    mission, pool
        The mission, and its faults.
    """

    def __init__(self, mission: Mission, pool: FaultPool) -> None:
        super().__init__()
        self._mission = mission
        self._pool = pool

    def __missing__(self, fault_id: str) -> tuple[int, tuple[Target | str, ...]]:
        fault = self._pool[fault_id]
        keys: tuple[Target | str, ...] = (fault_id, *touched(self._mission, fault))
        self[fault_id] = found = (len(fault.kind.parameters), keys)
        return found

    def require(self, specification: Specification) -> None:
        """Refuse a specification as ``require_no_overlap`` does."""
        newest: dict[Target | str, TimedFault] = {}
        for timed in sorted(specification, key=attrgetter("start")):
            fault, start, finish, values = timed
            n_values, keys = self[fault]
            if not 0 <= start <= finish or len(values) != n_values:
                raise SpecificationError(
                    f"fault '{fault}' has window {start} … {finish} and {len(values)} values; "
                    f"expected 0 <= start <= finish and {n_values} values",
                    (fault,),
                )
            for key in keys:
                before = newest.get(key)
                if before is not None and before.finish >= start:
                    raise self._overlap(before, timed)
                newest[key] = timed

    def _overlap(self, first: TimedFault, second: TimedFault) -> SpecificationError:
        """Return the error that two conflicting faults overlap."""
        others = {*self[second.fault][1]}
        shared = (key for key in self[first.fault][1] if key in others and not isinstance(key, str))
        what = ", ".join(describe(self._mission, key) for key in shared) or "nothing"
        return SpecificationError(
            f"faults '{first.fault}' ({first.start} … {first.finish}) and '{second.fault}' "
            f"({second.start} … {second.finish}) overlap and both touch {what}; "
            "conflicting faults must not be active at the same tick",
            (first.fault, second.fault),
        )
