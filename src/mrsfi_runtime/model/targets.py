"""Which properties of which robots, sensors and obstacles a fault touches."""

from collections.abc import Iterable, Iterator, Sequence
from typing import TypeAlias

from mrsfi_runtime.errors import SpecificationError
from mrsfi_runtime.model.fault_types import IN_NO_MESSAGE, OF_ROBOT, OF_SENSOR, Field, Struck
from mrsfi_runtime.model.faults import Fault
from mrsfi_runtime.model.mission import Message, Mission, Obstacle, Robot, Sensor

Target: TypeAlias = tuple[Field, int]
"""A property and the index of the robot, sensor or obstacle that has it."""

_OF_ANY_SENSOR = (*OF_SENSOR, Field.ACTIVATION)

_BY_NAME = {affected.name: affected for affected in OF_ROBOT}
"""What the entries of a message's body stand for; all others are types of sensors."""


def touched(mission: Mission, fault: Fault) -> tuple[Target, ...]:
    """Return what a fault touches, each once, in model order; nothing if no message carries it.

    A fault that refers to an element that the mission does not have is refused.
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
    for entry in message.body:
        if entry.name in _BY_NAME:
            yield _BY_NAME[entry.name], robot
        else:
            for sensor in mission.robots[robot].sensors:
                if sensor.type == entry.name:
                    yield Field.COUNT, mission.sensor_index[sensor.id]
