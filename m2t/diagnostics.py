"""Diagnostics of models: the constraints, a defect of one, and the report of all defects.

A report only collects: checks continue after a defect, and loading asks at the end how many errors
there are. Every message ends with the name of its constraint. The tables ``_ERRORS`` and
``_WARNINGS`` list all constraints in the order in which they are checked. Begin with these tables,
then read ``Report.add``.
"""

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Any, Literal, Protocol, TypeAlias, get_args

from mrsfi_runtime.errors import ModelError, nearest

Severity: TypeAlias = Literal["error", "warning"]


@dataclass(frozen=True, slots=True)
class Diagnostic:
    """One defect of a model; an error stops loading, a warning does not.

    ``line`` counts from 1, ``element`` is like ``robots 'r1'``, ``constraint`` one of
    ``CONSTRAINTS``; ``message`` gives the finding, the expectation, and the next step.
    """

    path: Path
    line: int
    element: str
    constraint: str
    severity: Severity
    message: str

    def __str__(self) -> str:
        return f"{self.path}:{self.line}: {self.message} [{self.constraint}]"


@dataclass(frozen=True, slots=True)
class Constraint:
    """A rule for models.

    ``evl`` is the file in ``metamodels`` that states it for Epsilon; if empty, ``reason`` says why
    there is none.
    """

    severity: Severity
    meaning: str
    evl: str
    reason: str


_REASONS: Mapping[str, str] = {
    "file": "concerns the file itself, which Eclipse no longer shows once the model is loaded",
    "metamodel": "concerns a metamodel, which is read before any model",
    "refused": "Eclipse refuses to load such a file",
    "dropped": "Eclipse drops the error silently while it loads the file",
}
"""Reasons why a constraint is not stated in EVL. The tables below have, in brackets, the key of the
reason, or the file that states the constraint."""

_ERRORS = """
ReadableFile (file): the file exists and can be read
FileSize (file): the file stays within the limits on bytes, elements and nesting
WellFormedXml (refused): the file is well-formed XML
NoDocumentType (file): the file declares no document type and no entities
RootElement (file): the root is the class that the file is for, in its namespace
KnownFeature (refused): every attribute and element is a feature of its class
NoText (dropped): text stands in attributes only
RequiredFeature (mission): every attribute and element that the metamodel requires is given
SingleValue (dropped): a single-valued feature is given once
ConcreteType (refused): xsi:type names a concrete class that fits the feature
ContainedElement (file): a contained element stands in its container or is the root of another file;
    a reference holds no element
NumberSyntax (refused): numbers are written as numbers of their type
FiniteNumber (mission): numbers are finite
NumberMagnitude (mission): numbers are from -1.0E12 to 1.0E12, the range of the simulation
EnumLiteral (refused): enumerations have one of their literals
StringLength (mission): texts stay within their limits
NameSyntax (metamodel): in metamodels, names and literals begin with an ASCII letter and contain
    only ASCII letters, digits and _
IdSyntax (mission): IDs begin with a letter and contain letters, digits, _ - . and spaces
ReservedId (mission): no ID of a mission becomes a name that Python or generated code uses itself
UniqueId (mission): IDs are unique over all classes of a file
IdClash (mission): IDs of a mission become different names in Python
ResolvedReference (mission): references lead to an element
ReferenceType (refused): references lead to an element of the declared class
UniqueReference (dropped): a list of references names each element once
LocalReference (file): references between files lead to files of the mission, in its project
DurationInRange (mission): the duration of a mission or a trigger is 1 to 10,000,000 ticks
RadiusPositive (mission): an area or a robot has a radius above 0
AreaShape (mission): an area has either a radius or 3 to 64 corners; only obstacles and the areas of
    GatherSamples, Patrol and Stay have corners
SpeedNotNegative (mission): a speed is not below 0
TurnRateInRange (mission): a turn rate is above 0 and at most 180 degrees per tick
NoiseNotNegative (mission): a noise is not below 0
ClearanceNotNegative (mission): a clearance is not below 0
EnergyNotNegative (mission): energies and energy costs are not below 0
SamplesPerSecondPositive (mission): a sensor takes at least 1 sample per tick
TargetSampleNumberNotNegative (mission): a number of samples is not below 0
RequiredMembersNotNegative (mission): a number of required members is not below 0
GraceNotNegative (mission): a grace is not below 0
SeverityInRange (mission): the severity of a goal is 1 to 10
PeriodPositive (mission): a patrol period is at least 1 tick
DeadlinePositive (mission): a deadline is tick 1 or later
TolerancePositive (mission): a tolerance is above 0
FixedDistancePositive (mission): a fixed distance is above 0
DelayNotNegative (faults): delays, also of triggers, and block durations are 0 to 2,147,483,647
WindowNotNegative (faults): the window of a fault does not begin or end before tick 0
LikelihoodInRange (faults): the likelihood of a fault is 0 to 1
PolygonEdges (mission): the edges of a polygon meet at its corners only
PolygonCenter (mission): the centre of a polygon is inside it
SpeedWithinMaximum (mission): a nominal speed is not above the maximum of its robot
MessageFieldName (mission): a message reports POSITION, SPEED, ENERGY or a sensor type
MessageFieldType (mission): a message field is of type Coordinates, Int, Double or String
SenderIsNotReceiver (mission): the receiver of a message is not its sender
UniquePropertyName (mission): user-defined properties of one station have different names
GoalDependsOnOthers (mission): a goal does not depend on itself
RequiredMembersAvailable (mission): a goal does not require more members than it has
RequiredMembersCounted (mission): a goal requires some of its members only if its task is judged
    member by member
AreaOrRoute (mission): a patrol has an area or a route, not both
GraceInsideMission (mission): a grace is shorter than its mission
GatherSamplesArea (mission): a goal that gathers samples has an area
SensorOfMember (mission): the sensor of a goal belongs to one of its members
PairOfMembers (mission): a goal that keeps a distance between robots has at least two members
ExactlyOneFaultType (faults): a fault contains exactly one fault type
RandomBoundsOrdered (faults): the lowest random value of a fault is not above its highest
SearchBoundsOrdered (faults): the lowest value of a parameter is not above its highest
WholeTicks (faults): delays and block durations are whole numbers of ticks
WindowComplete (faults): a fault has both start and finish, or neither
WindowOrdered (faults): a fault does not finish before it starts
TriggerInWindow (faults): a fault that waits for a trigger has a window
TriggerOfEvent (faults): a trigger refers to exactly what its event needs
ReachableGoal (faults): a trigger waits to reach only goals whose task can be reached
"""

_WARNINGS = """
IdWithoutSpaces (mission): IDs contain no spaces, so that an attribute can refer to them
AreaInsideMission (mission): areas lie inside the mission area
RobotInsideMission (mission): robots start inside the mission area
RobotStartsClear (mission): robots start clear of obstacles and of each other
RobotHasBattery (mission): a robot starts with energy in its batteries
SenderIsMember (mission): the messages of a goal are sent by its members
UniqueMessageField (mission): a message reports each field once
FieldOfSender (mission): a message reports only sensor types that its sender has
AvoidCollisionMembers (mission): robots that avoid collisions are members of their goal
DeadlineInsideMission (mission): a deadline lies inside the mission
FigureInsideMission (mission): speeds, distances, noises, radii of robots, clearances and tolerances
    are at most the width of the mission area; periods are at most the duration of the mission
AsReactionsAssume (mission): a robot has the room that built-in reactions need for its turn rate and
    its noise: areas and tolerances are wide enough
FaultFieldCarried (faults): the message of a fault carries the field that the fault falsifies
WindowInsideMission (faults): a fault starts before the mission ends
TriggerCanHappen (faults): a trigger of an effect waits for a fault that does not wait for it
"""

CONSTRAINTS: Mapping[str, Constraint] = {
    name: Constraint(
        severity,
        " ".join(meaning.split()),
        "" if where in _REASONS else f"{where}.evl",
        _REASONS.get(where, ""),
    )
    for severity, text in zip(get_args(Severity), (_ERRORS, _WARNINGS), strict=True)
    for name, where, meaning in re.findall(r"(?m)^(\w+) \((\w+)\): (.*(?:\n    .*)*)", text)
}
"""All constraints by name, in the order in which they are checked; no other name is reported."""


class Defect(Exception):  # noqa: N818 # models have defects
    """A violation of a named constraint, by an element or file that the caller knows.

    ``finding`` is the end of the message: the finding, the expectation, and the next step.
    """

    def __init__(self, constraint: str, finding: str) -> None:
        super().__init__(finding)
        self.constraint = constraint
        self.finding = finding


class Place(Protocol):
    """Place of an element in a file, and its name in messages."""

    path: Path
    line: int

    @property
    def description(self) -> str:
        """Name of the element, such as ``robots 'r1'``."""


@dataclass(frozen=True, slots=True)
class FileLine:
    """Place of a defect of a whole file."""

    path: Path
    line: int

    @property
    def description(self) -> str:
        """Name of the file."""
        return self.path.name


class Report:
    """Collects the diagnostics of one validation; ``n_errors`` of them stop loading.

    ``n_unsound`` of those prevent sound objects; a repeated reference does not, as the list of
    objects holds it once. ``n_dangling`` are references to missing elements: objects can be made
    without them. ``places`` maps objects to their places, and may grow.
    """

    def __init__(self, places: Mapping[Any, Place] = MappingProxyType({})) -> None:
        self.places = places
        self._found: dict[tuple[object, ...], Diagnostic] = {}
        self.n_errors = 0
        self.n_unsound = 0
        self.n_dangling = 0

    def place(self, element: Any) -> Place:
        """Return the place of an object; a place is returned unchanged."""
        return self.places.get(element, element)

    def add(self, element: Any, constraint: str, finding: str) -> None:
        """Add a defect of an object or a place; ``finding`` follows its name in the message."""
        place = self.place(element)
        key = (place, constraint, finding)
        if key in self._found:  # of a feature that several classes inherit, for example
            return
        severity, name = CONSTRAINTS[constraint].severity, place.description
        found = Diagnostic(place.path, place.line, name, constraint, severity, f"{name} {finding}")
        self._found[key] = found
        is_error = severity == "error"
        self.n_errors += is_error
        self.n_unsound += is_error and constraint != "UniqueReference"
        self.n_dangling += constraint == "ResolvedReference"

    def require_no_errors(self) -> None:
        """Raise a ``ModelError`` with all errors so far, one per line, if there are any."""
        if self.n_errors:
            raise self.error()

    def error(self) -> ModelError:
        """Return an error with all errors so far, one per line."""
        return ModelError("\n".join(str(found) for found in self if found.severity == "error"))

    def __iter__(self) -> Iterator[Diagnostic]:
        return iter(self._found.values())


def shown(text: str) -> str:
    """Return a text of a model for use in a message: quoted, on one line, shortened."""
    return repr(text if len(text) <= 60 else text[:60] + "...")


def listed(names: Sequence[str], found: str = "") -> str:
    """Return names for use in a message, with a suggestion of the intended one."""
    return ", ".join(names) + nearest(found, names)
