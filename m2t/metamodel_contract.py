"""What mrsfi reads of the metamodels: classes and features that they have to keep.

A team may add classes, subclasses and features of its own, and literals to enumerations. What
is named here keeps its name, its type, and whether it holds one value or many. Fault types are
not named: what they mean is said by annotations, which ``m2t.metamodel_fault_types`` reads.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Literal, TypeAlias

Holding: TypeAlias = Literal["value", "part", "link"]

BOUNDS = ("_MIN", "_MAX")
"""What the names of the attributes end with that bound a parameter for search."""

OURS = "http://mrsfi.org/"
"""What the sources of our annotations begin with."""

MEANING = f"{OURS}meaning"
"""Source of the annotations that say what a fault type and its parameters mean."""

_TEXT, _WHOLE, _NUMBER = "EString", "EInt", "EDouble"


@dataclass(frozen=True, slots=True)
class Need:
    """A feature that is read.

    Attributes
    ----------
    holding
        Whether it is an attribute, contains elements, or refers to them.
    type
        Name of its type; a subclass of it serves as well.
    n_least
        Number of values that every element has to have at least.
    is_many
        Whether it holds a list.
    is_id
        Whether it identifies its element.
    """

    holding: Holding
    type: str
    n_least: int = 1
    is_many: bool = False
    is_id: bool = False

    def __str__(self) -> str:
        kind = {"value": "an attribute", "part": "a containment", "link": "a reference"}
        number = "many values" if self.is_many else "one value"
        least = f", at least {self.n_least}" if self.n_least else ""
        identity = ", the ID" if self.is_id else ""
        return f"{kind[self.holding]} of type {self.type} for {number}{least}{identity}"


Needs: TypeAlias = Mapping[str, Need]


def _value(kind: str, n_least: int = 1) -> Need:
    return Need("value", kind, n_least)


def _part(kind: str, n_least: int = 1) -> Need:
    return Need("part", kind, n_least)


def _parts(kind: str, n_least: int = 0) -> Need:
    return Need("part", kind, n_least, is_many=True)


def _link(kind: str) -> Need:
    return Need("link", kind)


def _links(kind: str, n_least: int = 0) -> Need:
    return Need("link", kind, n_least, is_many=True)


_IDENTIFIED: Needs = {"ID": replace(_value(_TEXT), is_id=True)}
_COMPONENT: Needs = {**_IDENTIFIED, "name": _value(_TEXT)}
_STATION: Needs = {
    **_COMPONENT,
    "intProperties": _parts("IntProperty"),
    "stringProperties": _parts("StringProperty"),
    "doubleProperties": _parts("DoubleProperty"),
}

_MISSION: Mapping[str, Needs] = {
    "Mission": {
        "name": _value(_TEXT),
        "duration": _value(_WHOLE),
        "missionArea": _part("Area"),
        "robots": _parts("Robot", 1),
        "servers": _parts("Server"),
        "obstacles": _parts("Obstacle"),
        "goals": _parts("Goal", 1),
    },
    "Robot": {
        **_STATION,
        "speed": _value(_NUMBER),
        "position": _part("Coordinates", 0),
        "sensors": _parts("Sensor"),
        "batteries": _parts("Battery"),
        "motionSources": _parts("MotionSource"),
    },
    "Server": _STATION,
    "Sensor": {
        **_COMPONENT,
        "type": _value("SensorType"),
        "energyPerSample": _value(_NUMBER, 0),
        "samplesPerSecond": _value(_WHOLE),
    },
    "Battery": {**_COMPONENT, "totalEnergy": _value(_NUMBER)},
    "MotionSource": {**_COMPONENT, "energyPerDistanceUnit": _value(_NUMBER)},
    "IntProperty": {"name": _value(_TEXT), "value": _value(_WHOLE)},
    "StringProperty": {"name": _value(_TEXT), "value": _value(_TEXT)},
    "DoubleProperty": {"name": _value(_TEXT), "value": _value(_NUMBER)},
    "Coordinates": {axis: _value(_NUMBER, 0) for axis in ("x", "y", "z")},
    "Area": {**_IDENTIFIED, "radius": _value(_NUMBER), "center": _part("Coordinates", 0)},
    "Obstacle": {**_IDENTIFIED, "area": _part("Area")},
    "Message": {
        **_IDENTIFIED,
        "header": _value(_TEXT, 0),
        "sender": _link("Station"),
        "receiver": _link("Station"),
        "body": _parts("MessageData", 1),
    },
    "MessageData": {"name": _value(_TEXT), "type": _value(_TEXT)},
    "Goal": {
        **_COMPONENT,
        "members": _links("Robot", 1),
        "dependentGoals": _links("Goal"),
        "area": _part("Area", 0),
        "task": _part("GoalTask"),
        "messages": _parts("Message"),
    },
}

_TASKS: Mapping[str, Needs] = {
    "AvoidCollision": {"robots": _links("Robot", 1), "obstacles": _links("Obstacle")},
    "StayWithinMissionArea": {},
    "SufficientEnergy": {},
    "GatherSamples": {"targetSampleNumber": _value(_WHOLE), "sensor": _link("Sensor")},
    "Patrol": {"area": _part("Area"), "period": _value(_WHOLE)},
    "Visit": {
        "coordinates": _part("Coordinates"),
        "tolerance": _value(_NUMBER, 0),
        "deadline": _value(_WHOLE),
    },
    "Track": {"trajectory": _parts("Coordinates", 2), "tolerance": _value(_NUMBER)},
    "Stay": {"area": _part("Area")},
    "FixedDistanceBetweenRobots": {
        "fixedDistance": _value(_NUMBER),
        "tolerance": _value(_NUMBER, 0),
    },
}


_STRUCK: Mapping[str, Needs] = {
    "MessageFault": {"affectedMessage": _link("Message")},
    "RobotFault": {"affectedRobot": _link("Robot")},
    "SensorFault": {"affectedSensor": _link("Sensor")},
    "ObstacleFault": {"affectedObstacle": _link("Obstacle")},
}

_FAULTS: Mapping[str, Needs] = {
    "FaultSpecification": {**_IDENTIFIED, "faults": _parts("Fault")},
    "Fault": {**_COMPONENT, "start": _value(_WHOLE, 0), "finish": _value(_WHOLE, 0)},
    "FaultType": {},
    **_STRUCK,
}

OWN_TASK = "OwnTask"
"""What a goal task of a team's own is in the runtime."""

PROGRESSING = frozenset({"GatherSamples", "Patrol", "Visit", "Track", "Stay"})
"""Goal tasks that note once a tick what their check and reaction have to remember."""

CONTRACT: Mapping[str, Mapping[str, Needs]] = MappingProxyType(
    {"mission": {**_MISSION, **_TASKS}, "faults": _FAULTS}
)
"""What is read, by package, class and feature, inherited features included."""

SUPERTYPES: Mapping[str, Mapping[str, str]] = MappingProxyType(
    {
        "mission": {"Robot": "Station", "Server": "Station", **dict.fromkeys(_TASKS, "GoalTask")},
        "faults": dict.fromkeys(_STRUCK, "FaultType"),
    }
)
"""What a class has to inherit from, by package and class."""
