"""Between which bounds search may choose the values of a fault's parameters.

A bound is what the model says, else a default that the mission gives; the pool's own
value always lies inside.

References
----------
Source paper, section III-E b), which leaves the bounds open.
"""

import math

from mrsfi_runtime.model.fault_types import Field, Mode, Parameter
from mrsfi_runtime.model.faults import Fault
from mrsfi_runtime.model.mission import Mission, Robot
from mrsfi_runtime.model.targets import touched

_REACH = 1.5  # mission radii around the centre
_EXCESS = 10.0  # times nominal
_PERCENT_MODES = (Mode.INCREMENT_PERCENT, Mode.DECREMENT_PERCENT)
_TIME_MODES = (Mode.DELAY, Mode.BLOCK)


def value_bounds(mission: Mission, fault: Fault) -> tuple[tuple[float, float], ...]:
    """Return the lowest and highest value of each parameter of a pool fault.

    Returns
    -------
    tuple[tuple[float, float], ...]
        Shape ``(n_parameters, 2)`` in the order of ``fault.kind.parameters``. A parameter
        that does not evolve has its pool value twice. The bounds of an integer parameter
        are the outermost whole numbers inside; if there is none, its pool value twice.

    Raises
    ------
    SpecificationError
        If the fault refers to an element that the mission does not have.
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
    lowest, highest = _default_bounds(mission, fault, parameter)
    model_lowest, model_highest = fault.bounds.get(parameter.name, (None, None))
    low = min(lowest if model_lowest is None else model_lowest, value)
    high = max(highest if model_highest is None else model_highest, value)
    if parameter.is_integer:
        low, high = float(math.ceil(low)), float(math.floor(high))
        return (low, high) if low <= high else (value, value)
    return low, high


def _default_bounds(mission: Mission, fault: Fault, parameter: Parameter) -> tuple[float, float]:
    kind = fault.kind
    if kind.mode in _TIME_MODES:
        return 1.0, float(mission.duration)
    if kind.mode in _PERCENT_MODES:
        return 0.0, 100.0
    if kind.affected in (Field.POSITION, Field.OBSTACLE):
        center, reach = mission.area.center, _REACH * mission.area.radius
        middle = center.x if parameter.name == "NEW_X" else center.y
        return middle - reach, middle + reach
    return 0.0, _largest(mission, fault)


def _largest(mission: Mission, fault: Fault) -> float:
    """Return the default upper bound of an energy, speed, rate or cost."""
    affected = fault.kind.affected
    if affected in (Field.RATE, Field.COST):
        sensors = [mission.sensors[index] for _, index in touched(mission, fault)]
        nominal = (
            float(sensor.samples_per_second) if affected is Field.RATE else sensor.energy_per_sample
            for sensor in sensors
        )
        return _EXCESS * max(nominal, default=0.0)
    robot = _sender(mission, fault)
    if robot is None:
        return 0.0
    return robot.total_energy if affected is Field.ENERGY else _EXCESS * robot.speed


def _sender(mission: Mission, fault: Fault) -> Robot | None:
    """Return the robot whose message is affected; a server reports nothing of its own."""
    touched(mission, fault)  # refuses a message that the mission does not have
    sender = mission.message_goal[fault.target][0].sender
    index = mission.robot_index.get(sender)
    return None if index is None else mission.robots[index]
