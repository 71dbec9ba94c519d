"""Fault types: a mode, the properties that it touches, and parameters.

``metamodels/faults.ecore`` defines the fault types in annotations that use the words of the
enumerations here. A generated fault loader carries those of its pool as ``FaultType`` values.
``ROLES`` lists the parameters of a mode for each property, ``WITHIN_REACH`` the properties that a
fault can touch. ``plain_name`` turns an ID into a name for Python and for topics of ROS.

``SEMANTICS`` is the version of the world's rules (docs/semantics.md). Records, generated code and
the bus carry it. It changes when the same faults in the same mission may lead to another flight.
Files of another version can be read, but not flown:

Version 1
    mrsfi 0.1. Verdicts and reactions depend on the last bit; belief begins without a speed; a robot
    obeys commands up to five times its nominal speed.
Version 2
    mrsfi 0.3. Verdicts have a tolerance and reactions a reserve; belief begins with the model's
    values; a robot obeys commands up to its own greatest speed; an outcome has missed goals.

Begin with ``FaultType``.

References
----------
Source paper, section III-B b).
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import Enum, IntEnum

from mrsfi_runtime.errors import counted


class Field(IntEnum):
    """A property that a fault can touch; with the index of its owner: a target."""

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
    """Effect on the property while the fault is active."""

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
    OWN = 13  # a user-defined effect, in a region of the generated code


class Range(Enum):
    """The quantity of a parameter, from which default bounds for search follow."""

    TICKS = "ticks"
    PERCENT = "percent"
    SHARE = "share"
    SPEED = "units per tick"
    ENERGY = "energy units"
    COUNT = "samples"
    RATE = "samples per tick"
    COST = "energy per sample"
    X = "first coordinate"
    Y = "second coordinate"
    Z = "height"


@dataclass(frozen=True, slots=True)
class Units:
    """The units of printed quantities, each empty if the model names none; ``time`` is a tick's."""

    distance: str = ""
    time: str = ""
    energy: str = ""

    def of(self, measured: Range) -> str:
        """Return the unit of a quantity, by default one of ours; shares have none."""
        match measured:
            case Range.X | Range.Y | Range.Z:
                return self.distance
            case Range.SPEED:
                return f"{self.distance or 'units'} per {self.time or 'tick'}"
            case Range.RATE:
                return f"samples per {self.time or 'tick'}"
            case Range.COST:
                return f"{self.energy or 'energy'} per sample"
        ours = "" if measured is Range.SHARE else measured.value
        return {Range.TICKS: self.time, Range.ENERGY: self.energy}.get(measured, "") or ours

    def quantity(self, value: float, measured: Range, digits: int = 4) -> str:
        """Return a rounded quantity with its unit: ``3 energy units``, ``41.2 m``, ``71000 m``."""
        rounded = float(f"{value:.{digits}g}")
        return f"{rounded:.15g} {self.of(measured)}".rstrip()

    def ticks(self, number: int) -> str:
        """Return a number of ticks with its unit: ``1 tick``, ``2 ticks``, ``2 s``."""
        return f"{number} {self.time}" if self.time else counted(number, "ticks")


class Role(Enum):
    """Role of a parameter for the mode of its type."""

    VALUE = "value"
    LOWEST = "lowest value"
    HIGHEST = "highest value"
    TICKS = "ticks"
    PERCENT = "percentage"
    X = "x"
    Y = "y"
    Z = "z"


class Struck(Enum):
    """The kind of model element that a fault refers to."""

    MESSAGE = "message"
    ROBOT = "robot"
    SENSOR = "sensor"
    OBSTACLE = "obstacle"


@dataclass(frozen=True, slots=True)
class Parameter:
    """A parameter of a fault type, spelled as in the metamodel.

    Search may change it if it ``evolves``. Its values are whole numbers if it ``is_integer``.
    """

    name: str
    range: Range
    evolves: bool = True
    is_integer: bool = False


@dataclass(frozen=True, slots=True)
class FaultType:
    """A kind of disturbance.

    ``properties`` is empty for delays and blocks, which touch all that their message carries.
    ``parameters`` have the order of a fault's ``values``, and of the roles of the mode. ``effect``
    numbers user-defined effects.
    """

    name: str
    mode: Mode
    struck: Struck
    properties: tuple[Field, ...] = ()
    parameters: tuple[Parameter, ...] = ()
    effect: int = -1

    @property
    def is_place(self) -> bool:
        """Whether the parameters are coordinates."""
        ranges = [parameter.range for parameter in self.parameters]
        return ranges[:2] == [Range.X, Range.Y] and set(ranges[2:]) <= {Range.Z}

    def named(self, values: Sequence[float]) -> dict[str, float]:
        """Return values by the names of the parameters."""
        return dict(zip((each.name for each in self.parameters), values, strict=True))

    def in_words(self, values: Sequence[float], units: Units, digits: int = 6) -> str:
        """Return values with names and units: ``DELAY 200 ticks``."""
        return ", ".join(
            f"{each.name} {units.quantity(value, each.range, digits)}"
            for each, value in zip(self.parameters, values, strict=True)
        )


REPORTED = (Field.SPEED, Field.ENERGY, Field.COUNT, Field.RATE, Field.COST)
"""Properties that are one number, with the range of the same name."""

PLACES = (Field.POSITION, Field.OBSTACLE)  # properties that are a place


def _on(properties: tuple[Field, ...], *roles: Role) -> Mapping[Field | None, tuple[Role, ...]]:
    return dict.fromkeys(properties, roles)


ROLES: Mapping[Mode, Mapping[Field | None, tuple[Role, ...]]] = {
    Mode.DELAY: {None: (Role.TICKS,)},
    Mode.BLOCK: {None: (Role.TICKS,)},
    Mode.RANDOM: {**_on(REPORTED, Role.LOWEST, Role.HIGHEST), **_on(PLACES)},
    Mode.ZERO: _on(REPORTED),
    Mode.FIXED: {**_on(REPORTED, Role.VALUE), **_on(PLACES, Role.X, Role.Y, Role.Z)},
    Mode.INCREMENT: _on(REPORTED, Role.VALUE),
    Mode.DECREMENT: _on(REPORTED, Role.VALUE),
    Mode.INCREMENT_PERCENT: _on(REPORTED, Role.PERCENT),
    Mode.DECREMENT_PERCENT: _on(REPORTED, Role.PERCENT),
    Mode.STOP: {Field.MOTION: ()},
    Mode.START: {Field.MOTION: ()},
    Mode.DEACTIVATE: {Field.ACTIVATION: ()},
    Mode.ACTIVATE: {Field.ACTIVATION: ()},
}
"""The properties that a mode acts on, with the parameters of each in order. ``None`` stands for all
that a message carries. A height, ``Role.Z``, may be absent."""

OF_ROBOT = (Field.POSITION, Field.SPEED, Field.ENERGY)
"""Properties of a robot that its messages report."""

OF_SENSOR = (Field.COUNT, Field.RATE, Field.COST)  # properties of a sensor that are believed

IN_NO_MESSAGE = (Field.RATE, Field.COST)
"""Properties that no message carries; belief has the model's values."""

ELEMENTS = (OF_ROBOT, OF_SENSOR, (Field.OBSTACLE,))
"""Properties by kind of owner; a user-defined effect acts on one of the three."""

N_VALUES = 8  # parameters of a user-defined type, at most

WITHIN_REACH: Mapping[Struck, tuple[Field | None, ...]] = {
    Struck.MESSAGE: (None, *OF_ROBOT, *OF_SENSOR),
    Struck.ROBOT: (*OF_ROBOT, *OF_SENSOR, Field.MOTION),
    Struck.SENSOR: (*OF_SENSOR, Field.ACTIVATION),
    Struck.OBSTACLE: (Field.OBSTACLE,),
}
"""The properties that a fault can touch, by the kind of element it refers to: those of a message's
sender, of a robot and its sensors, of a sensor, of an obstacle."""


def plain_name(text: str) -> str:
    """Return an ID in lower case, runs of separators as one underscore.

    The IDs of a valid mission become different names, each ``[a-z][a-z0-9_]*``.

    Examples
    --------
    >>> plain_name("Scout-1")
    'scout_1'
    """
    return re.sub(r"[_. -]+", "_", text).strip("_").lower()


SEMANTICS = 3  # the version that this runtime flies


def difference(found: int) -> str:
    """Return the error message about a version that cannot be flown."""
    return (
        f"found semantics {found}; expected semantics {SEMANTICS}, which this mrsfi flies "
        "(docs/semantics.md)"
    )
