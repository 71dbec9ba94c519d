"""Metaclasses: those that code reads, their features, and the names of elements in code.

``CONTRACT`` lists the classes and features that mrsfi reads. Users may add classes, subclasses,
features and literals; a listed feature keeps its name, its type, and whether it has one value or
many. Fault types are not listed: annotations give their meaning (``m2t.metamodels``).

Next come the names of elements in generated code, which derive from IDs and never from display
names; then queries of metaclasses (``lineage``, ``features``, ``slots``) and of elements. All of
them list features in the order of the metamodel, inherited ones first.
"""

import keyword
import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any, TypeAlias

from pyecore.ecore import EClass, EEnum, EProxy, EReference

from mrsfi_runtime.errors import ModelError
from mrsfi_runtime.model.fault_types import Range, plain_name

BOUNDS = ("_MIN", "_MAX")
"""Suffixes of the attributes that bound a parameter for search."""

OURS = "http://mrsfi.org/"
"""Prefix of the sources of our annotations."""

MEANING = f"{OURS}meaning"
"""Source of the annotations that give the meaning of a fault type and its parameters."""

OWN_TASK = "OwnTask"
"""Class of a user-defined goal task in the runtime."""

PROGRESSING = frozenset({"GatherSamples", "Patrol", "Visit", "Track", "Stay"})
"""Goal tasks that record their progress once a tick."""

_IDENTIFIED = "id EString[1] ID"
_NAMED = f"{_IDENTIFIED}, attr EString[1] name"
_STATION = (
    f"{_NAMED}, val IntProperty[*] intProperties, val StringProperty[*] stringProperties, "
    "val DoubleProperty[*] doubleProperties"
)

_MISSION = f"""
Mission: attr EString[1] name, attr EInt[1] duration, attr EString[?] distanceUnit,
    attr EString[?] timeUnit, attr EString[?] energyUnit, val Area[1] missionArea,
    val Robot[+] robots, val Server[*] servers, val Obstacle[*] obstacles,
    val Requirement[*] requirements, val Goal[+] goals
Robot extends Station: {_STATION}, attr EDouble[1] speed, attr EDouble[?] maxSpeed,
    attr EDouble[?] turnRate, attr EDouble[?] positionNoise, attr EDouble[?] radius,
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
Area: {_IDENTIFIED}, attr EDouble[?] radius, val Coordinates[?] center, val Coordinates[*] corners
Obstacle: {_IDENTIFIED}, val Area[1] area
Message: {_IDENTIFIED}, attr EString[?] header, ref Station[1] sender, ref Station[1] receiver,
    val MessageData[+] body
MessageData: attr EString[1] name, attr EString[1] type
Requirement: {_IDENTIFIED}, attr EString[1] text
Goal: {_NAMED}, ref Robot[+] members, attr EInt[?] requiredMembers, attr EInt[?] grace,
    ref Goal[*] dependentGoals, ref Requirement[*] requirements, attr EInt[?] severity,
    attr EString[?] integrityLevel, attr EString[?] rationale, val Area[?] area,
    val GoalTask[1] task, val Message[*] messages
AvoidCollision extends GoalTask: ref Robot[+] robots, ref Obstacle[*] obstacles,
    attr EDouble[?] clearance
StayWithinMissionArea extends GoalTask:
SufficientEnergy extends GoalTask:
GatherSamples extends GoalTask: attr EInt[1] targetSampleNumber, ref Sensor[1] sensor
Patrol extends GoalTask: val Area[?] area, val Area[*] route, attr EInt[1] period
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
    attr EString[?] reference, ref Trigger[?] trigger
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
    ``number`` is the required number of values: ``1``, ``?``, ``*``, ``+`` or ``2..*``.
    """

    holding: str
    type: str
    number: str

    @property
    def n_least(self) -> int:
        """Least number of values of every element."""
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
    """Return the needs in a text in the notation of this module, by class and feature."""
    return {
        name: {feature: Need(*need) for *need, feature in _FEATURE.findall(features)}
        for name, _, features in _CLASS.findall(text)
    }


CONTRACT: Mapping[str, Mapping[str, Needs]] = {"mission": needs(_MISSION), "faults": needs(_FAULTS)}
"""Features that are read, by package and class, inherited features included."""

SUPERTYPES: Mapping[str, Mapping[str, str]] = {
    package: {name: parent for name, parent, _ in _CLASS.findall(text) if parent}
    for package, text in (("mission", _MISSION), ("faults", _FAULTS))
}
"""Required supertype of a class, by package and class."""


RESERVED = frozenset({"checks", "reactions", "topics", "commands", "truth"})
"""Identifiers that generated code itself uses, as tables or as a root of topics."""


def identifier(text: str) -> str:
    """Return the identifier that a model ID becomes in Python and in ROS topic names.

    It is lower case, ``[a-z][a-z0-9_]*``; runs of ``_``, ``-``, ``.`` and spaces become one
    underscore. An ID with characters other than these and ASCII letters and digits, without a
    letter at its start, or that becomes a reserved name, raises a ``ModelError``.

    Examples
    --------
    >>> identifier("Scout-1")
    'scout_1'
    """
    name = plain_name(text)
    if not re.fullmatch(r"[A-Za-z0-9_. -]+", text):
        characters = "ASCII letters, digits, '_', '-', '.' or spaces"
        wrong = f"cannot be a name in Python; expected {characters}"
    elif not re.fullmatch(r"[a-z][a-z0-9_]*", name):
        wrong = f"becomes '{name[:40]}', which is no name in Python; expected a letter at the start"
    elif keyword.iskeyword(name) or name in RESERVED:
        wrong = f"becomes '{name}', which Python or generated code uses itself"
    else:
        return name
    shown = ascii(text if len(text) <= 60 else f"{text[:60]}...")
    raise ModelError(f"ID {shown} {wrong}; rename the element")


def constant(text: str) -> str:
    """Return the constant that stands for a model ID: its identifier in upper case."""
    return identifier(text).upper()


def snake_case(class_name: str) -> str:
    """Return a class name in lower case with underscores between its words.

    Examples
    --------
    >>> snake_case("FixedDistanceBetweenRobots")
    'fixed_distance_between_robots'
    """
    return re.sub(r"(?<=[a-z0-9])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z])", "_", class_name).lower()


@cache
def lineage(metaclass: Any) -> tuple[Any, ...]:
    """Return a metaclass after all its supertypes, the most general one first."""
    parents = [
        ancestor for parent in metaclass.eSuperTypes for ancestor in lineage(_resolved(parent))
    ]
    return (*dict.fromkeys(parents), metaclass)


@cache
def features(metaclass: Any) -> tuple[Any, ...]:
    """Return all features of a metaclass in the order of Eclipse: inherited ones first.

    pyecore's own order is the other way round for some collections and none for others.
    """
    return tuple(feature for known in lineage(metaclass) for feature in known.eStructuralFeatures)


@dataclass(frozen=True, slots=True, eq=False)
class Slot:
    """A feature with the attributes that loading needs, because pyecore's own are slow to read.

    ``counts_ticks`` is true of a parameter of a fault type in ticks, and of its bounds.
    """

    feature: Any
    name: str
    type: Any
    many: bool
    lower_bound: int
    is_contained: bool
    is_reference: bool
    is_id: bool
    counts_ticks: bool

    @property
    def holds_elements(self) -> bool:
        """Whether its values are elements, contained or referred to."""
        return self.is_contained or self.is_reference


@cache
def slots(metaclass: Any) -> Mapping[str, Slot]:
    """Return the slots of all features of a metaclass by name, inherited ones first."""
    in_ticks = {
        feature.name
        for feature in features(metaclass)
        for note in feature.eAnnotations
        if note.source == MEANING and note.details.get("range") == Range.TICKS.name
    }
    return {
        str(feature.name): Slot(
            feature,
            str(feature.name),
            _resolved(feature.eType),
            bool(feature.many),
            int(feature.lowerBound),
            isinstance(feature, EReference) and bool(feature.containment),
            isinstance(feature, EReference) and not feature.containment,
            bool(getattr(feature, "iD", False)),
            any(f"{name}{end}" == feature.name for name in in_ticks for end in ("", *BOUNDS)),
        )
        for feature in features(metaclass)
    }


@cache
def conforms(metaclass: Any, wanted: Any) -> bool:
    """Return whether a metaclass is another one or one of its subclasses."""
    return any(known is wanted for known in lineage(metaclass))


@cache
def concrete_classes(package: Any, declared: Any) -> Mapping[str, Any]:
    """Return the classes of a package whose objects a feature of a declared class may hold."""
    return {
        str(kind.name): kind
        for kind in package.eClassifiers
        if isinstance(kind, EClass) and not kind.abstract and conforms(kind, declared)
    }


@cache
def base_class(metaclass: Any) -> Any:
    """Return the class of an element in code: the nearest of its lineage that mrsfi reads.

    A user-defined subclass only adds features to such a class; a class without one is returned
    itself.
    """
    read = (known for known in reversed(lineage(metaclass)) if is_read(known))
    return next((known for known in read if not known.abstract), metaclass)


@cache
def is_read(metaclass: Any, feature: str = "") -> bool:
    """Return whether code reads a class of the metamodel, or a feature that elements of it have."""
    needs = CONTRACT.get(metaclass.ePackage.name, {}).get(metaclass.name)
    return needs is not None and (not feature or feature in needs)


@cache
def is_kind(metaclass: Any, name: str) -> bool:
    """Return whether a metaclass has a name, or inherits from the class of that name."""
    return any(known.name == name for known in lineage(metaclass))


def _resolved(metaclass: Any) -> Any:
    """Return the metaclass behind the proxy of another metamodel file."""
    return metaclass.force_resolve() if isinstance(metaclass, EProxy) else metaclass


def values(element: Any, slot: Slot) -> list[Any]:
    """Return the values of an element's feature: one, many, or none."""
    value = getattr(element, slot.name)
    if slot.many:
        return list(value)
    return [] if value is None else [value]


def is_set(element: Any, name: str) -> bool:
    """Return whether the model gives an optional feature that the element's class has."""
    slot = slots(element.eClass).get(name)
    return slot is not None and bool(element.eIsSet(slot.feature))


def put(element: Any, slot: Slot, value: Any) -> None:
    """Set a feature of an element, or add to its values if it holds many."""
    if slot.many:
        getattr(element, slot.name).append(value)
    else:
        setattr(element, slot.name, value)


def contained(element: Any) -> Iterator[Any]:
    """Yield an element and all elements in it, in the order in which they are written."""
    yield element
    for slot in slots(element.eClass).values():
        if slot.is_contained:
            for child in values(element, slot):
                yield from contained(child)


def copies(roots: Iterable[Any], known: Callable[[Any], Any] = lambda kind: kind) -> dict[Any, Any]:
    """Return copies of elements with all elements in them, by their originals.

    References to other elements stay the same, and unset features stay unset. ``known`` returns the
    class or enumeration of the copies for a given one. All copies are made before any gets its
    values, which may refer to any of them.
    """
    made = {element: known(element.eClass)() for root in roots for element in contained(root)}
    for element, copy in made.items():
        for slot in slots(element.eClass).values():
            if slot.many or element.eIsSet(slot.feature):
                for value in values(element, slot):
                    is_literal = isinstance(slot.type, EEnum)
                    same = known(slot.type).getEEnumLiteral(value.name) if is_literal else value
                    put(copy, slot, made.get(same, same))
    return made
