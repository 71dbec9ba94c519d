"""Between which bounds search may choose the values of a fault's parameters.

A bound is what the model says, else a default that the mission gives for the parameter's range;
the pool's own value always lies inside.

References
----------
Source paper, section III-E b), which leaves the bounds open.
"""

import math

from mrsfi_runtime.model.fault_types import OF_SENSOR, Parameter, Range, Struck
from mrsfi_runtime.model.faults import Fault
from mrsfi_runtime.model.gate import limits
from mrsfi_runtime.model.mission import Mission, Robot, Sensor
from mrsfi_runtime.model.targets import touched

_REACH = 1.5  # mission radii around the centre
_EXCESS = 10.0  # times nominal


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
    center, reach, duration = mission.area.center, _REACH * mission.area.radius, mission.duration
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
    robots = _robots(mission, fault)
    sensors = _sensors(mission, fault, robots)
    largest = {
        Range.ENERGY: [robot.total_energy for robot in robots],
        Range.SPEED: [_EXCESS * robot.speed for robot in robots],
        Range.RATE: [_EXCESS * sensor.samples_per_second for sensor in sensors],
        Range.COST: [_EXCESS * sensor.energy_per_sample for sensor in sensors],
    }
    return 0.0, max(largest[of], default=0.0)


def _robots(mission: Mission, fault: Fault) -> tuple[Robot, ...]:
    """Return the robots that a fault strikes: none if a server's message, all if an obstacle."""
    touched(mission, fault)  # refuses what the mission does not have
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


def _sensors(mission: Mission, fault: Fault, robots: tuple[Robot, ...]) -> tuple[Sensor, ...]:
    """Return the sensors that a fault touches, else all of the robots that it strikes."""
    if fault.kind.struck is Struck.SENSOR:
        return (mission.sensors[mission.sensor_index[fault.target]],)
    found = tuple(
        mission.sensors[index] for field, index in touched(mission, fault) if field in OF_SENSOR
    )
    return found or tuple(sensor for robot in robots for sensor in robot.sensors)
