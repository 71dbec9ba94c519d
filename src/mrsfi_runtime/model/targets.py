"""Which properties a fault touches, and which faults therefore conflict.

Two faults conflict when they touch the same property of the same target: one would
disable the other. Conflicting faults never overlap in one specification.

References
----------
Source paper, sections III-C b), III-E b) and c). The paper says *same message* in one
place and *same class* in another; this key serves the purpose it states.
"""

from collections.abc import Mapping
from typing import TypeAlias

from mrsfi_runtime.errors import SpecificationError
from mrsfi_runtime.model.fault_types import Field
from mrsfi_runtime.model.faults import Fault, FaultPool, Specification, TimedFault
from mrsfi_runtime.model.mission import Mission

Target: TypeAlias = tuple[Field, int]
"""A property and the index of the robot, sensor or obstacle that has it."""

_ROBOT_FIELDS = {
    "POSITION": Field.POSITION,
    "SPEED": Field.SPEED,
    "ENERGY": Field.ENERGY,
}


def touched(mission: Mission, fault: Fault) -> tuple[Target, ...]:
    """Return what a fault touches, in model order; empty if its message does not carry it.

    Raises
    ------
    SpecificationError
        If the fault refers to an element that the mission does not have.
    """
    key = (fault.type, fault.target)
    if key not in mission.touches:
        mission.touches[key] = _found(mission, fault)
    return mission.touches[key]


def _found(mission: Mission, fault: Fault) -> tuple[Target, ...]:
    kind = fault.kind
    try:
        if kind.affected is Field.OBSTACLE:
            return ((Field.OBSTACLE, mission.obstacle_index[fault.target]),)
        if kind.affected is Field.MOTION:
            return ((Field.MOTION, mission.robot_index[fault.target]),)
        if kind.affected is Field.ACTIVATION:
            return ((Field.ACTIVATION, mission.sensor_index[fault.target]),)
        return _touched_by_message(mission, fault)
    except KeyError as error:
        message = (
            f"fault '{fault.id}' ({fault.type}) refers to {error.args[0]!r}; "
            f"mission '{mission.name}' has no such {kind.targets}"
        )
        raise SpecificationError(message) from None


def _touched_by_message(mission: Mission, fault: Fault) -> tuple[Target, ...]:
    message, goal = mission.message_goal[fault.target]
    if message.sender not in mission.robot_index:  # a server reports nothing of its own
        return ()
    robot = mission.robot_index[message.sender]
    sensors = {
        sensor.id: mission.sensor_index[sensor.id] for sensor in mission.robots[robot].sensors
    }
    affected = fault.kind.affected
    if affected in (Field.RATE, Field.COST):
        counted = goal.terms.sensor
        if counted in sensors:
            return ((affected, sensors[counted]),)
        return tuple((affected, index) for index in sensors.values())
    carried: list[Target] = []
    for entry in message.body:
        if entry.name in _ROBOT_FIELDS:
            carried.append((_ROBOT_FIELDS[entry.name], robot))
        else:
            carried.extend(
                (Field.COUNT, sensors[sensor.id])
                for sensor in mission.robots[robot].sensors
                if sensor.type == entry.name
            )
    return tuple(target for target in carried if affected is None or target[0] is affected)


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
    for timed in specification:
        n_values = len(pool[timed.fault].kind.parameters)
        if timed.start < 0 or timed.finish < timed.start or len(timed.values) != n_values:
            message = (
                f"fault '{timed.fault}' has window {timed.start} … {timed.finish} and "
                f"{len(timed.values)} values; expected 0 <= start <= finish and {n_values} values"
            )
            raise SpecificationError(message)
    busy: dict[Target | str, list[TimedFault]] = {}
    for second in specification:
        keys: list[Target | str] = [second.fault, *touched(mission, pool[second.fault])]
        for key in keys:
            others = busy.setdefault(key, [])
            for first in others:
                if first.start <= second.finish and second.start <= first.finish:
                    raise SpecificationError(_overlap(mission, pool, first, second))
            others.append(second)


def _overlap(mission: Mission, pool: FaultPool, first: TimedFault, second: TimedFault) -> str:
    """Return the message about two conflicting faults that overlap."""
    shared = {*touched(mission, pool[first.fault])} & {*touched(mission, pool[second.fault])}
    what = ", ".join(sorted(target[0].name.lower() for target in shared)) or "nothing"
    return (
        f"faults '{first.fault}' ({first.start} … {first.finish}) and '{second.fault}' "
        f"({second.start} … {second.finish}) overlap and both touch {what}; "
        "conflicting faults must not be active at the same tick"
    )
