"""What mrsfi reads of the metamodels: classes and features that they have to keep.

A team may add classes, subclasses and features of its own, and literals to enumerations. What
is named here keeps its name, its type, and whether it holds one value or many. Fault types are
not named: what they mean is said by annotations, which ``m2t.metamodel_fault_types`` reads.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TypeAlias

BOUNDS = ("_MIN", "_MAX")
"""What the names of the attributes end with that bound a parameter for search."""

OURS = "http://mrsfi.org/"
"""What the sources of our annotations begin with."""

MEANING = f"{OURS}meaning"
"""Source of the annotations that say what a fault type and its parameters mean."""

OWN_TASK = "OwnTask"
"""What a goal task of a team's own is in the runtime."""

PROGRESSING = frozenset({"GatherSamples", "Patrol", "Visit", "Track", "Stay"})
"""Goal tasks that note once a tick what their check and reaction have to remember."""

_IDENTIFIED = "id EString[1] ID"
_NAMED = f"{_IDENTIFIED}, attr EString[1] name"
_STATION = (
    f"{_NAMED}, val IntProperty[*] intProperties, val StringProperty[*] stringProperties, "
    "val DoubleProperty[*] doubleProperties"
)

_MISSION = f"""
Mission: attr EString[1] name, attr EInt[1] duration, attr EString[?] distanceUnit,
    attr EString[?] timeUnit, attr EString[?] energyUnit, val Area[1] missionArea,
    val Robot[+] robots, val Server[*] servers, val Obstacle[*] obstacles, val Goal[+] goals
Robot extends Station: {_STATION}, attr EDouble[1] speed, attr EDouble[?] maxSpeed,
    attr EDouble[?] turnRate, attr EDouble[?] positionNoise,
    val Coordinates[?] position, val Sensor[*] sensors, val Battery[*] batteries,
    val MotionSource[*] motionSources
Server extends Station: {_STATION}
Sensor: {_NAMED}, attr SensorType[1] type, attr EDouble[?] energyPerSample,
    attr EInt[1] samplesPerSecond
Battery: {_NAMED}, attr EDouble[1] totalEnergy
MotionSource: {_NAMED}, attr EDouble[1] energyPerDistanceUnit
IntProperty: attr EString[1] name, attr EInt[1] value
StringProperty: attr EString[1] name, attr EString[1] value
DoubleProperty: attr EString[1] name, attr EDouble[1] value
Coordinates: attr EDouble[?] x, attr EDouble[?] y, attr EDouble[?] z
Area: {_IDENTIFIED}, attr EDouble[1] radius, val Coordinates[?] center
Obstacle: {_IDENTIFIED}, val Area[1] area
Message: {_IDENTIFIED}, attr EString[?] header, ref Station[1] sender, ref Station[1] receiver,
    val MessageData[+] body
MessageData: attr EString[1] name, attr EString[1] type
Goal: {_NAMED}, ref Robot[+] members, ref Goal[*] dependentGoals, val Area[?] area,
    val GoalTask[1] task, val Message[*] messages
AvoidCollision extends GoalTask: ref Robot[+] robots, ref Obstacle[*] obstacles
StayWithinMissionArea extends GoalTask:
SufficientEnergy extends GoalTask:
GatherSamples extends GoalTask: attr EInt[1] targetSampleNumber, ref Sensor[1] sensor
Patrol extends GoalTask: val Area[1] area, attr EInt[1] period
Visit extends GoalTask: val Coordinates[1] coordinates, attr EDouble[?] tolerance,
    attr EInt[1] deadline
Track extends GoalTask: val Coordinates[2..*] trajectory, attr EDouble[1] tolerance
Stay extends GoalTask: val Area[1] area
FixedDistanceBetweenRobots extends GoalTask: attr EDouble[1] fixedDistance,
    attr EDouble[?] tolerance
"""

_FAULTS = f"""
FaultSpecification: {_IDENTIFIED}, val Fault[*] faults, val Trigger[*] triggers
Fault: {_NAMED}, attr EInt[?] start, attr EInt[?] finish, attr EDouble[?] likelihood,
    ref Trigger[?] trigger
Trigger: {_IDENTIFIED}, attr TriggerEvent[1] event, ref Goal[?] goal, ref Robot[?] robot,
    val Area[?] area, ref Area[?] at, ref Fault[*] faults, attr EInt[?] delay, attr EInt[?] duration
FaultType:
MessageFault extends FaultType: ref Message[1] affectedMessage
RobotFault extends FaultType: ref Robot[1] affectedRobot
SensorFault extends FaultType: ref Sensor[1] affectedSensor
ObstacleFault extends FaultType: ref Obstacle[1] affectedObstacle
"""

_CLASS = re.compile(r"^(\w+)(?: extends (\w+))?:(.*(?:\n    .*)*)", re.MULTILINE)
_FEATURE = re.compile(r"(id|attr|val|ref) ([\w|]+)\[(\S+)\] (\w+)")
_LEAST = {"?": 0, "*": 0, "1": 1, "+": 1, "2..*": 2}


@dataclass(frozen=True, slots=True)
class Need:
    """A feature that is read, of the type of that name or a subclass of it.

    ``holding`` is ``id`` or ``attr`` for an attribute, ``val`` for one that contains elements,
    ``ref`` for one that refers to them: the words of Emfatic, Eclipse's notation for metamodels.
    ``number`` of values every element has to have: ``1``, ``?``, ``*``, ``+`` or ``2..*``.
    """

    holding: str
    type: str
    number: str

    @property
    def n_least(self) -> int:
        """Number of values that every element has to have at least."""
        return _LEAST[self.number]

    @property
    def is_many(self) -> bool:
        """Whether it holds a list."""
        return self.number not in {"1", "?"}

    def __str__(self) -> str:
        kind = {"val": "a containment", "ref": "a reference"}.get(self.holding, "an attribute")
        number = "many values" if self.is_many else "one value"
        least = f", at least {self.n_least}" if self.n_least else ""
        identity = ", the ID" if self.holding == "id" else ""
        return f"{kind} of type {self.type} for {number}{least}{identity}"


Needs: TypeAlias = Mapping[str, Need]


def needs(text: str) -> Mapping[str, Needs]:
    """Return what a text in the notation of this module needs, by class and feature."""
    return {
        name: {feature: Need(*need) for *need, feature in _FEATURE.findall(features)}
        for name, _, features in _CLASS.findall(text)
    }


CONTRACT: Mapping[str, Mapping[str, Needs]] = {"mission": needs(_MISSION), "faults": needs(_FAULTS)}
"""What is read, by package, class and feature, inherited features included."""

SUPERTYPES: Mapping[str, Mapping[str, str]] = {
    package: {name: parent for name, parent, _ in _CLASS.findall(text) if parent}
    for package, text in (("mission", _MISSION), ("faults", _FAULTS))
}
"""What a class has to inherit from, by package and class."""
