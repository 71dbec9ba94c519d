"""The 30 fault types, as one table: what each touches, how, and with which parameters.

A fault type is a *mode* applied to a *property*. Message faults (delay and block) touch
every property that their message carries; all others touch one kind of property.

References
----------
Source paper, section III-B b).
"""

from collections.abc import Mapping
from dataclasses import dataclass
from enum import IntEnum
from types import MappingProxyType


class Field(IntEnum):
    """What a fault can touch; with the index of its robot, sensor or obstacle: a target."""

    POSITION = 0  # believed position of a robot
    SPEED = 1  # believed speed of a robot
    ENERGY = 2  # believed energy of a robot
    COUNT = 3  # believed number of samples of a sensor
    RATE = 4  # believed samples per tick of a sensor
    COST = 5  # believed energy per sample of a sensor
    OBSTACLE = 6  # an obstacle on the server's map
    MOTION = 7  # the speed command of a robot
    ACTIVATION = 8  # the activation of a sensor


class Mode(IntEnum):
    """What happens to the property while the fault is active."""

    DELAY = 0
    BLOCK = 1
    RANDOM = 2
    ZERO = 3
    FIXED = 4
    INCREMENT = 5  # by a value
    DECREMENT = 6
    INCREMENT_PERCENT = 7
    DECREMENT_PERCENT = 8
    STOP = 9
    START = 10
    DEACTIVATE = 11
    ACTIVATE = 12


@dataclass(frozen=True, slots=True)
class Parameter:
    """A parameter of a fault type, spelled as in the metamodel.

    ``evolves`` says whether search may change it; ``is_integer`` whether only whole
    numbers make sense.
    """

    name: str
    evolves: bool = True
    is_integer: bool = False


@dataclass(frozen=True, slots=True)
class FaultType:
    """A kind of disturbance.

    ``affected`` is ``None`` for the two message faults, which touch whatever their message
    carries. ``parameters`` fixes the order of a fault's ``values``.
    """

    name: str
    mode: Mode
    affected: Field | None
    parameters: tuple[Parameter, ...] = ()

    @property
    def targets(self) -> str:
        """Kind of model element that the fault refers to: message, robot, sensor or obstacle."""
        if self.affected is Field.MOTION:
            return "robot"
        if self.affected is Field.ACTIVATION:
            return "sensor"
        if self.affected is Field.OBSTACLE:
            return "obstacle"
        return "message"


def _value_types(
    suffix: str, affected: Field, *, is_integer: bool, by_percentage: bool
) -> tuple[FaultType, ...]:
    """Return the five types that falsify one reported value."""
    random_bounds = tuple(Parameter(name, evolves=False) for name in ("LOWER_BOUND", "UPPER_BOUND"))
    step = Parameter("PERCENTAGE") if by_percentage else Parameter("VAL", is_integer=True)
    increment = Mode.INCREMENT_PERCENT if by_percentage else Mode.INCREMENT
    decrement = Mode.DECREMENT_PERCENT if by_percentage else Mode.DECREMENT
    return (
        FaultType(f"Random{suffix}", Mode.RANDOM, affected, random_bounds),
        FaultType(f"Zero{suffix}", Mode.ZERO, affected),
        FaultType(
            f"Fixed{suffix}", Mode.FIXED, affected, (Parameter("FIXED_VAL", is_integer=is_integer),)
        ),
        FaultType(f"Increment{suffix}", increment, affected, (step,)),
        FaultType(f"Decrement{suffix}", decrement, affected, (step,)),
    )


_NEW_COORDINATES = (Parameter("NEW_X"), Parameter("NEW_Y"), Parameter("NEW_Z", evolves=False))

_ALL = (
    FaultType("DelayMessage", Mode.DELAY, None, (Parameter("DELAY", is_integer=True),)),
    FaultType("BlockMessage", Mode.BLOCK, None, (Parameter("BLOCK_DURATION", is_integer=True),)),
    *_value_types(
        "RemainingEnergyCapacityReport", Field.ENERGY, is_integer=False, by_percentage=True
    ),
    *_value_types("SensorEnergyPerSample", Field.COST, is_integer=False, by_percentage=True),
    *_value_types("Speed", Field.SPEED, is_integer=True, by_percentage=False),
    *_value_types("SampleRate", Field.RATE, is_integer=True, by_percentage=False),
    FaultType("FixedRobotCoordinates", Mode.FIXED, Field.POSITION, _NEW_COORDINATES),
    FaultType("RandomRobotCoordinates", Mode.RANDOM, Field.POSITION),
    FaultType("FixedObstacleCoordinates", Mode.FIXED, Field.OBSTACLE, _NEW_COORDINATES),
    FaultType("RandomObstacleCoordinates", Mode.RANDOM, Field.OBSTACLE),
    FaultType("StopRobot", Mode.STOP, Field.MOTION),
    FaultType("StartRobot", Mode.START, Field.MOTION),
    FaultType("DeactivateSensor", Mode.DEACTIVATE, Field.ACTIVATION),
    FaultType("ActivateSensor", Mode.ACTIVATE, Field.ACTIVATION),
)

FAULT_TYPES: Mapping[str, FaultType] = MappingProxyType({kind.name: kind for kind in _ALL})
"""The fault types by name, in the order of the design's table."""
