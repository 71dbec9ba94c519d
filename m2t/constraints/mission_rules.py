"""Constraints on missions that no metamodel can state.

References
----------
Source paper, section III-B a).
"""

import math
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator
from itertools import chain, product
from typing import Any, TypeAlias

from pyecore.ecore import EObject

from m2t.diagnostics import Report, listed, shown
from m2t.metaclasses import base_class, is_kind, is_set
from m2t.write.xmi import java_double
from mrsfi_runtime.model.mission import ROBOT_RADIUS

ROBOT_FIELDS = ("POSITION", "SPEED", "ENERGY")
FIELD_TYPES = ("Coordinates", "Int", "Double", "String")
_ASSUMED = {"turnRate": 180.0, "positionNoise": 0.0}
_LENGTHS = {
    "Robot": ("speed", "maxSpeed", "positionNoise"),
    "Visit": ("tolerance",),
    "Track": ("tolerance",),
    "FixedDistanceBetweenRobots": ("fixedDistance", "tolerance"),
}

Point: TypeAlias = tuple[float, float]


def check_mission(mission: Any, report: Report) -> None:
    """Check a mission whose structure is sound."""
    for robot in mission.robots:
        _check_robot(mission, robot, report)
    for station in (*mission.robots, *mission.servers):
        _check_property_names(station, report)
    for area in areas(mission):
        _check_area(mission, area, report)
    _check_starts(mission, report)
    for goal in mission.goals:
        _check_goal(mission, goal, report)


def point(coordinates: Any) -> Point:
    """Return a point in the plane; the origin stands for an absent one."""
    return (0.0, 0.0) if coordinates is None else (coordinates.x, coordinates.y)


def distance(one: Point, other: Point) -> float:
    """Return the distance of two points, rounded as ``mission.evl`` rounds it."""
    dx, dy = one[0] - other[0], one[1] - other[1]
    return math.sqrt(dx * dx + dy * dy)


def strangers(goal: Any) -> list[Any]:
    """Return the robots that a goal to avoid collisions names but does not have as members."""
    return [robot for robot in goal.task.robots if robot not in goal.members]


def number(value: float) -> str:
    """Return a number for messages, spelt as in the file."""
    return str(value) if isinstance(value, int) else java_double(value)


def repeated(entries: Iterable[Any]) -> Iterator[Any]:
    """Yield the entries that have the name of one before them."""
    names: set[str] = set()
    for entry in entries:
        if entry.name in names:
            yield entry
        names.add(entry.name)


def areas(mission: Any) -> Iterator[Any]:
    """Return all areas but the mission's own, in model order."""
    for obstacle in mission.obstacles:
        yield obstacle.area
    for goal in mission.goals:
        if goal.area is not None:
            yield goal.area
        own = getattr(goal.task, "area", None)
        if isinstance(own, EObject) and is_kind(own.eClass, "Area"):
            yield own


def _ids(elements: Any) -> str:
    return listed([str(element.ID) for element in elements]) or "none"


def _check_robot(mission: Any, robot: Any, report: Report) -> None:
    if is_set(robot, "maxSpeed") and robot.speed > robot.maxSpeed:
        finding = (
            f"has speed {number(robot.speed)} above maxSpeed {number(robot.maxSpeed)}; expected a "
            "nominal speed that it can reach; correct one of them"
        )
        report.add(robot, "SpeedWithinMaximum", finding)
    _check_figures(mission, robot, report)
    for name, assumed in _ASSUMED.items():
        if is_set(robot, name) and getattr(robot, name) != assumed:
            finding = (
                f"has {name} {number(getattr(robot, name))}, which the built-in reactions ignore, "
                "so that goals may be violated without any fault; expected none; delete it, or "
                "write reactions that reckon with it"
            )
            report.add(robot, "AsReactionsAssume", finding)
    area = mission.missionArea
    if distance(point(robot.position), point(area.center)) > area.radius:
        finding = (
            f"starts outside the mission area (radius {number(area.radius)}); expected a position "
            "inside it; correct the position or the area"
        )
        report.add(robot, "RobotInsideMission", finding)
    if sum(battery.totalEnergy for battery in robot.batteries) <= 0:
        finding = "has no energy to begin with and will never move; expected a battery; add one"
        report.add(robot, "RobotHasBattery", finding)


def _check_property_names(station: Any, report: Report) -> None:
    properties = (station.intProperties, station.stringProperties, station.doubleProperties)
    for entry in repeated(chain(*properties)):
        finding = (
            f"is a property of {report.place(station).description} for the second time; "
            "expected different names; rename one"
        )
        report.add(entry, "UniquePropertyName", finding)


def _check_area(mission: Any, area: Any, report: Report) -> None:
    outer = mission.missionArea
    if distance(point(area.center), point(outer.center)) + area.radius > outer.radius:
        finding = (
            f"reaches beyond the mission area (radius {number(outer.radius)}); expected an area "
            "inside it; correct one of them"
        )
        report.add(area, "AreaInsideMission", finding)


def _check_starts(mission: Any, report: Report) -> None:
    others = Discs()
    for obstacle in mission.obstacles:
        reach = obstacle.area.radius + ROBOT_RADIUS
        others.add(obstacle, point(obstacle.area.center), reach)
    for robot in mission.robots:
        place = point(robot.position)
        touched = others.first_around(place)
        if touched is not None:
            other = report.place(touched).description
            finding = (
                f"starts in contact with {other}; expected some distance; correct its position"
            )
            report.add(robot, "RobotStartsClear", finding)
        others.add(robot, place, ROBOT_RADIUS + ROBOT_RADIUS)


def _check_goal(mission: Any, goal: Any, report: Report) -> None:
    if goal in goal.dependentGoals:
        finding = "depends on itself; expected other goals; delete it from dependentGoals"
        report.add(goal, "GoalDependsOnOthers", finding)
    _check_figures(mission, goal.task, report)
    check = _TASK_CHECKS.get(base_class(goal.task.eClass).name)
    if check is not None:
        check(mission, goal, report)
    for message in goal.messages:
        _check_message(goal, message, report)


def _check_figures(mission: Any, element: Any, report: Report) -> None:
    """Check that no figure is so far outside its mission that it was meant in another unit."""
    base, width = base_class(element.eClass).name, 2 * mission.missionArea.radius
    limits = dict.fromkeys(_LENGTHS.get(base, ()), (width, f"an area {number(width)} wide"))
    if base == "Patrol":
        limits["period"] = (mission.duration, f"{mission.duration} ticks")
    for name, (most, size) in limits.items():
        if is_set(element, name) and getattr(element, name) > most:
            finding = (
                f"has {name} {number(getattr(element, name))} in a mission of {size}; expected no "
                "more than that; correct one of them, or the unit"
            )
            report.add(element, "FigureInsideMission", finding)


def _check_gather_samples(_: Any, goal: Any, report: Report) -> None:
    if goal.area is None:
        finding = "has no area to gather samples in; expected one; add <area ID=... radius=...>"
        report.add(goal, "GatherSamplesArea", finding)
    sensor = goal.task.sensor
    if sensor.eContainer() not in goal.members:
        finding = (
            f"uses sensor '{sensor.ID}' of robot '{sensor.eContainer().ID}'; expected a sensor of "
            f"a member ({_ids(goal.members)}); correct the sensor or the members"
        )
        report.add(goal.task, "SensorOfMember", finding)


def _check_avoid_collision(_: Any, goal: Any, report: Report) -> None:
    found = strangers(goal)
    if found:
        finding = (
            f"names {_ids(found)}; expected members of the goal "
            f"({_ids(goal.members)}); correct the robots or the members"
        )
        report.add(goal.task, "AvoidCollisionMembers", finding)


def _check_visit(mission: Any, goal: Any, report: Report) -> None:
    if goal.task.deadline >= mission.duration:
        finding = (
            f"has deadline {goal.task.deadline} in a mission of {mission.duration} ticks, so that "
            "it can never be violated; expected an earlier one; correct one of them"
        )
        report.add(goal.task, "DeadlineInsideMission", finding)


def _check_fixed_distance(_: Any, goal: Any, report: Report) -> None:
    if len(goal.members) < 2:
        finding = (
            "keeps a distance between robots but has one member; expected two or more; add one"
        )
        report.add(goal, "PairOfMembers", finding)


_TASK_CHECKS: dict[str, Callable[[Any, Any, Report], None]] = {
    "GatherSamples": _check_gather_samples,
    "AvoidCollision": _check_avoid_collision,
    "Visit": _check_visit,
    "FixedDistanceBetweenRobots": _check_fixed_distance,
}


def _check_message(goal: Any, message: Any, report: Report) -> None:
    sender = message.sender
    if sender is message.receiver:
        finding = (
            f"is sent by '{sender.ID}' to itself; expected somebody else; correct the receiver"
        )
        report.add(message, "SenderIsNotReceiver", finding)
    if sender not in goal.members:
        finding = (
            f"is sent by '{sender.ID}'; expected a member of the goal "
            f"({_ids(goal.members)}); correct the sender or the members"
        )
        report.add(message, "SenderIsMember", finding)
    again = set(repeated(message.body))
    for entry in message.body:
        _check_field(sender, entry, report)
        if entry in again:
            finding = "is reported twice by the same message; expected it once; delete one"
            report.add(entry, "UniqueMessageField", finding)


def _check_field(sender: Any, entry: Any, report: Report) -> None:
    carried = [sensor.type.name for sensor in getattr(sender, "sensors", ())]
    enumeration = sender.eClass.ePackage.getEClassifier("SensorType")
    sensor_types = [literal.name for literal in enumeration.eLiterals]
    known = (*ROBOT_FIELDS, *sensor_types)
    if entry.name not in known:
        finding = f"is no field of a message; expected one of {', '.join(known)}; correct the name"
        report.add(entry, "MessageFieldName", finding)
    elif entry.name in sensor_types and entry.name not in carried:
        finding = (
            f"is a sensor type of which '{sender.ID}' has no sensor; expected one of "
            f"{', '.join(dict.fromkeys(carried)) or 'none'}; correct the field or the sender"
        )
        report.add(entry, "FieldOfSender", finding)
    if entry.type not in FIELD_TYPES:
        finding = (
            f"has type {shown(entry.type)}; expected one of {', '.join(FIELD_TYPES)}; "
            "correct the type"
        )
        report.add(entry, "MessageFieldType", finding)


class Discs:
    """Discs in the plane, in order, each for an element.

    A disc lies in one cell of a grid whose cells are as wide as its radius or wider, up to twice,
    so that whatever it holds is in that cell or one beside it. Discs of like radius share a
    grid; there are as many grids as there are magnitudes of radii.
    """

    def __init__(self) -> None:
        self._discs: list[tuple[Any, Point, float]] = []
        self._grids: dict[float, dict[tuple[int, int], list[int]]] = {}

    def add(self, element: Any, center: Point, radius: float) -> None:
        """Add a disc after all others."""
        width = 2.0 ** math.frexp(radius)[1]
        cells = self._grids.setdefault(width, defaultdict(list))
        cells[_cell(center, width)].append(len(self._discs))
        self._discs.append((element, center, radius))

    def first_around(self, point: Point) -> Any:
        """Return the element of the first disc that a point lies inside of; ``None`` if none."""
        found = []
        for width, cells in self._grids.items():
            x, y = _cell(point, width)
            for dx, dy in product((-1, 0, 1), repeat=2):
                near = cells.get((x + dx, y + dy), ())
                found += next(([number] for number in near if self._holds(number, point)), [])
        return self._discs[min(found)][0] if found else None

    def _holds(self, number: int, point: Point) -> bool:
        _, center, radius = self._discs[number]
        return distance(point, center) < radius


def _cell(point: Point, width: float) -> tuple[int, int]:
    return math.floor(point[0] / width), math.floor(point[1] / width)
