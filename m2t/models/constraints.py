"""Constraints that no metamodel can state: on missions, on faults, and on IDs.

Each check gets objects whose structure is sound, so every required feature is present. Each
reports all its findings. docs/constraints.md lists the names of the constraints, and the EVL files
that state the same for Eclipse. Begin with ``check_mission``, ``check_faults`` and
``check_identities``, in this order.

References
----------
Source paper, section III-B a) and b).
"""

import math
import re
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from itertools import chain, product
from typing import Any, TypeAlias

from pyecore.ecore import EObject

from m2t.metaclasses import BOUNDS, base_class, identifier, is_kind, is_set, slots, values
from m2t.metamodels import meaning
from m2t.models.check import ModelTree
from m2t.models.write import java_double
from m2t.read import Defect, Node, Report, listed, shown
from mrsfi_runtime.errors import ModelError
from mrsfi_runtime.model.fault_types import OF_ROBOT, Field, Mode
from mrsfi_runtime.model.mission import Coordinates, polygon, turn_width
from mrsfi_runtime.model.polygons import meeting, near, off_polygon

_TOLERATING = {"Visit": 1.0, "Track": 1.0, "FixedDistanceBetweenRobots": 2.0}
"""How many times the leeway of a robot the tolerance of a task has to be."""
_NEEDS = "needs more room for its turnRate and positionNoise than it has"
_OWN = "the goal may be violated without any fault; expected more room, or another reaction"
FIELD_TYPES = ("Coordinates", "Int", "Double", "String")
_LENGTHS = {
    "Robot": ("speed", "maxSpeed", "positionNoise", "radius"),
    "AvoidCollision": ("clearance",),
    "Visit": ("tolerance",),
    "Track": ("tolerance",),
    "FixedDistanceBetweenRobots": ("fixedDistance", "tolerance"),
}

_JOINT_TASKS = ("AvoidCollision", "GatherSamples", "FixedDistanceBetweenRobots")

Point: TypeAlias = tuple[float, float]


def check_mission(mission: Any, report: Report) -> None:
    """Check a mission whose structure is sound."""
    for robot in mission.robots:
        _check_robot(mission, robot, report)
    for station in (*mission.robots, *mission.servers):
        properties = (station.intProperties, station.stringProperties, station.doubleProperties)
        for entry in repeated(chain(*properties)):
            finding = (
                f"is the second property of that name in {report.place(station).description}; "
                "expected different names; rename one"
            )
            report.add(entry, "UniquePropertyName", finding)
    outer = mission.missionArea
    for area in areas(mission):
        _check_polygon(area, report)
        if _reach(area, point(outer.center)) > outer.radius:
            finding = (
                f"reaches beyond the mission area (radius {number(outer.radius)}); expected an "
                "area inside it; correct one of them"
            )
            report.add(area, "AreaInsideMission", finding)
    _check_starts(mission, report)
    for goal in mission.goals:
        _check_goal(mission, goal, report)


def point(coordinates: Any) -> Point:
    """Return a point in the plane; the origin stands for an absent one."""
    return (0.0, 0.0) if coordinates is None else (coordinates.x, coordinates.y)


def distance(one: Point, other: Point) -> float:
    """Return the distance between two points, rounded as in ``mission.evl``."""
    dx, dy = one[0] - other[0], one[1] - other[1]
    return math.sqrt(dx * dx + dy * dy)


def corners(area: Any) -> list[Coordinates]:
    """Return the corners of an area; a disc has none."""
    return [Coordinates(each.x, each.y) for each in area.corners]


def _reach(area: Any, place: Point) -> float:
    """Return the distance of the farthest point of an area."""
    away = [distance(point(each), place) for each in area.corners]
    return max(away) if away else distance(point(area.center), place) + area.radius


def strangers(goal: Any) -> list[Any]:
    """Return the robots that an AvoidCollision task names but that are no members of its goal."""
    return [robot for robot in goal.task.robots if robot not in goal.members]


def number(value: float) -> str:
    """Return a number for messages, spelt as in the file."""
    return str(value) if isinstance(value, int) else java_double(value)


def repeated(entries: Iterable[Any]) -> Iterator[Any]:
    """Yield the entries that have the name of an earlier one."""
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
        if base_class(goal.task.eClass).name == "Patrol":
            yield from goal.task.route


def _ids(elements: Any) -> str:
    return listed([str(element.ID) for element in elements]) or "none"


def _check_polygon(area: Any, report: Report) -> None:
    edge = corners(area)
    met = meeting(edge) if edge else None
    if met is not None:
        finding = (
            f"has edges {met[0] + 1} and {met[1] + 1}, counted from its first corner, that meet; "
            "expected edges that meet at their common corners only; correct the corners"
        )
        report.add(area, "PolygonEdges", finding)
        return
    is_given = bool(edge) and area.center is not None
    if is_given and off_polygon(edge, 0, len(edge), *point(area.center)) >= -near(edge):
        finding = "has a center outside its edges; expected one inside; correct or delete it"
        report.add(area, "PolygonCenter", finding)


def _check_robot(mission: Any, robot: Any, report: Report) -> None:
    if is_set(robot, "maxSpeed") and robot.speed > robot.maxSpeed:
        finding = (
            f"has speed {number(robot.speed)} above maxSpeed {number(robot.maxSpeed)}; expected a "
            "nominal speed that it can reach; correct one of them"
        )
        report.add(robot, "SpeedWithinMaximum", finding)
    _check_figures(mission, robot, report)
    _check_reactions(mission, robot, report)
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


def _check_reactions(mission: Any, robot: Any, report: Report) -> None:
    """Check that a robot has room for its turn rate and noise where built-in reactions steer it."""
    for goal in mission.goals:
        for area in _kept_in(mission, goal, robot):
            if not area.corners and _leeway(robot) >= area.radius:
                room = f"area '{area.ID}' of goal '{goal.ID}' (radius {number(area.radius)})"
                report.add(robot, "AsReactionsAssume", f"{_NEEDS} in {room}; {_OWN}")
        base = base_class(goal.task.eClass).name
        share = _TOLERATING.get(base, 0.0) if robot in goal.members else 0.0
        needed = 2.0 * robot.positionNoise if base == "Visit" else _leeway(robot)
        if share and share * needed > goal.task.tolerance:
            room = f"the tolerance of goal '{goal.ID}' ({number(goal.task.tolerance)})"
            report.add(robot, "AsReactionsAssume", f"{_NEEDS} in {room}; {_OWN}")


def _kept_in(mission: Any, goal: Any, robot: Any) -> list[Any]:
    """Return the areas in which the built-in reaction of a goal keeps a robot."""
    task, base = goal.task, base_class(goal.task.eClass).name
    if base == "GatherSamples":
        return [goal.area] if task.sensor.eContainer() is robot and goal.area is not None else []
    kept = {
        "StayWithinMissionArea": lambda: [mission.missionArea],
        "Patrol": lambda: [*filter(None, [task.area]), *task.route],
        "Stay": lambda: [task.area],
    }
    return kept[base]() if base in kept and robot in goal.members else []


def _leeway(robot: Any) -> float:
    """Return how far from an edge the built-in reactions turn a robot back."""
    rate = robot.turnRate if is_set(robot, "turnRate") else 180.0
    width = turn_width(rate) + 0.5 if rate < 180.0 else 0.0
    return float(2.0 * robot.positionNoise + robot.speed * width)


def _check_starts(mission: Any, report: Report) -> None:
    others = Discs(max(robot.radius for robot in mission.robots))
    for obstacle in mission.obstacles:
        edge = corners(obstacle.area)
        disc = polygon("", tuple(edge)) if edge else obstacle.area
        others.add(obstacle, point(disc.center), disc.radius, edge)
    for robot in mission.robots:
        place = point(robot.position)
        touched = others.first_around(place, robot.radius)
        if touched is not None:
            finding = f"starts in contact with {report.place(touched).description}"
            advice = "expected some distance; correct its position"
            report.add(robot, "RobotStartsClear", f"{finding}; {advice}")
        others.add(robot, place, robot.radius)


def _check_goal(mission: Any, goal: Any, report: Report) -> None:
    if goal in goal.dependentGoals:
        finding = "depends on itself; expected other goals; delete it from dependentGoals"
        report.add(goal, "GoalDependsOnOthers", finding)
    _check_figures(mission, goal.task, report)
    _check_required_members(goal, report)
    if goal.grace >= mission.duration:
        finding = (
            f"has grace {goal.grace} in a mission of {mission.duration} ticks, so that it can "
            "never be violated; expected a shorter one; correct one of them"
        )
        report.add(goal, "GraceInsideMission", finding)
    check = _TASK_CHECKS.get(base_class(goal.task.eClass).name)
    if check is not None:
        check(mission.duration, goal, report)
    for message in goal.messages:
        _check_message(goal, message, report)


def _check_figures(mission: Any, element: Any, report: Report) -> None:
    """Check that no figure is so large for its mission that its unit is probably wrong."""
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


def _check_required_members(goal: Any, report: Report) -> None:
    n = len(goal.members)
    if goal.requiredMembers > n:
        finding = f"requires {goal.requiredMembers} of {n} members; expected no more than it has"
        report.add(goal, "RequiredMembersAvailable", f"{finding}; correct one of them")
    if goal.requiredMembers > 0 and base_class(goal.task.eClass).name in _JOINT_TASKS:
        finding = (
            f"has requiredMembers {goal.requiredMembers}, but its task is not judged member by "
            "member; expected none; delete it"
        )
        report.add(goal, "RequiredMembersCounted", finding)


def _check_gather_samples(_: int, goal: Any, report: Report) -> None:
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


def _check_avoid_collision(_: int, goal: Any, report: Report) -> None:
    if found := strangers(goal):
        finding = (
            f"names {_ids(found)}; expected members of the goal "
            f"({_ids(goal.members)}); correct the robots or the members"
        )
        report.add(goal.task, "AvoidCollisionMembers", finding)


def _check_patrol(_: int, goal: Any, report: Report) -> None:
    has_area, has_route = goal.task.area is not None, len(goal.task.route) > 0
    if has_area == has_route:
        found = "both an area and a route" if has_area else "neither an area nor a route"
        advice = "delete one" if has_area else "add <area ID=... radius=...> or several <route ...>"
        report.add(goal.task, "AreaOrRoute", f"has {found}; expected one of them; {advice}")


def _check_visit(duration: int, goal: Any, report: Report) -> None:
    if goal.task.deadline >= duration:
        finding = (
            f"has deadline {goal.task.deadline} in a mission of {duration} ticks, so that "
            "it can never be violated; expected an earlier one; correct one of them"
        )
        report.add(goal.task, "DeadlineInsideMission", finding)


def _check_fixed_distance(_: int, goal: Any, report: Report) -> None:
    if len(goal.members) < 2:
        finding = "keeps a distance between robots but has one member; expected two or more"
        report.add(goal, "PairOfMembers", f"{finding}; add one")


_TASK_CHECKS: dict[str, Callable[[int, Any, Report], None]] = {
    "GatherSamples": _check_gather_samples,
    "AvoidCollision": _check_avoid_collision,
    "Patrol": _check_patrol,
    "Visit": _check_visit,
    "FixedDistanceBetweenRobots": _check_fixed_distance,
}


def _check_message(goal: Any, message: Any, report: Report) -> None:
    sender = message.sender
    if sender is message.receiver:
        finding = f"is sent by '{sender.ID}' to itself; expected another receiver"
        report.add(message, "SenderIsNotReceiver", f"{finding}; correct it")
    if sender not in goal.members:
        finding = f"is sent by '{sender.ID}'; expected a member of the goal ({_ids(goal.members)})"
        report.add(message, "SenderIsMember", f"{finding}; correct the sender or the members")
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
    known = ("POSITION", "SPEED", "ENERGY", *sensor_types)
    if entry.name not in known:
        finding = f"is no field of a message; expected one of {', '.join(known)}; correct the name"
        report.add(entry, "MessageFieldName", finding)
    elif entry.name in sensor_types and entry.name not in carried:
        finding = (
            f"is a sensor type, and '{sender.ID}' has no such sensor; expected one of "
            f"{', '.join(dict.fromkeys(carried)) or 'none'}; correct the field or the sender"
        )
        report.add(entry, "FieldOfSender", finding)
    if entry.type not in FIELD_TYPES:
        finding = f"has type {shown(entry.type)}; expected one of {', '.join(FIELD_TYPES)}"
        report.add(entry, "MessageFieldType", f"{finding}; correct the type")


class Discs:
    """Discs in the plane, in order, each for an element.

    ``widest`` is the greatest radius of a disc that is looked for. A disc lies in one cell of a
    grid whose cells are one to two times as wide as its radius and ``widest`` together, so the
    centre of every disc that it meets is in that cell or an adjacent one. Discs of similar radius
    share a grid; there is one grid per magnitude (power of two) of radii.
    """

    def __init__(self, widest: float = 0.0) -> None:
        self._widest = widest
        self._discs: list[tuple[Any, Point, float, Sequence[Coordinates]]] = []
        self._grids: dict[float, dict[tuple[int, int], list[int]]] = {}

    def add(
        self, element: Any, center: Point, radius: float, edge: Sequence[Coordinates] = ()
    ) -> None:
        """Add a disc, or a polygon inside it, after all others."""
        width = 2.0 ** math.frexp(radius + self._widest)[1]
        cells = self._grids.setdefault(width, defaultdict(list))
        cells[_cell(center, width)].append(len(self._discs))
        self._discs.append((element, center, radius, edge))

    def first_around(self, point: Point, own: float = 0.0) -> Any:
        """Return the element of the first disc that meets one of radius ``own``, or ``None``."""
        found = []
        for width, cells in self._grids.items():
            x, y = _cell(point, width)
            for dx, dy in product((-1, 0, 1), repeat=2):
                for number in cells.get((x + dx, y + dy), ()):
                    _, center, radius, edge = self._discs[number]
                    is_near = distance(point, center) < radius + own
                    if is_near and (not edge or off_polygon(edge, 0, len(edge), *point) < own):
                        found.append(number)
                        break
        return self._discs[min(found)][0] if found else None


def _cell(point: Point, width: float) -> tuple[int, int]:
    return math.floor(point[0] / width), math.floor(point[1] / width)


Pairs: TypeAlias = list[tuple[str, str]]
"""Pairs of feature names: the value of the first must not exceed that of the second."""


def check_faults(specification: Any, duration: int, report: Report) -> None:
    """Check a fault specification whose structure is sound, for a mission's duration in ticks."""
    for fault in specification.faults:
        _check_window(fault, duration, report)
        kinds = fault_types(fault)
        if len(kinds) == 1:
            _check_parameters(kinds[0], report)
            _check_fault_field(kinds[0], report)
            continue
        found = ", ".join(kind.eClass.name for kind in kinds) or "none"
        finding = f"contains {len(kinds)} fault types ({found}); expected exactly one"
        advice = "delete the others" if kinds else "add one"
        report.add(fault, "ExactlyOneFaultType", f"{finding}; {advice}")
    for trigger in specification.triggers:
        _check_trigger(trigger, report)


def fault_types(fault: Any) -> tuple[Any, ...]:
    """Return the fault types that a fault contains; a sound fault contains one."""
    return tuple(
        kind
        for slot in slots(fault.eClass).values()
        if slot.is_contained and is_kind(slot.type, "FaultType") and fault.eIsSet(slot.feature)
        for kind in values(fault, slot)
    )


def exchanged_window(fault: Any) -> Pairs:
    """Return the names of start and finish if a fault finishes before it starts."""
    return _exchanged(fault, _given(fault, ("start", "finish")))


def exchanged_draw(kind: Any) -> Pairs:
    """Return the names of the lowest and highest random value of a fault type, if exchanged."""
    names = [parameter.name for parameter in meaning(kind).parameters]
    is_drawn = meaning(kind).mode is Mode.RANDOM and names
    return _exchanged(kind, [(names[0], names[1])] if is_drawn else [])


def exchanged_bounds(kind: Any) -> Pairs:
    """Return the names of the bounds of each parameter whose lower one exceeds the upper one."""
    low, high = BOUNDS
    names = [parameter.name for parameter in meaning(kind).parameters]
    return _exchanged(kind, _given(kind, *((f"{name}{low}", f"{name}{high}") for name in names)))


def _given(element: Any, *pairs: tuple[str, str]) -> Pairs:
    return [pair for pair in pairs if all(is_set(element, name) for name in pair)]


def _exchanged(element: Any, pairs: Pairs) -> Pairs:
    return [pair for pair in pairs if getattr(element, pair[0]) > getattr(element, pair[1])]


def broken_ticks(kind: Any) -> list[str]:
    """Return the features of a fault type whose number of ticks is not whole."""
    return [
        name
        for name, slot in slots(kind.eClass).items()
        if slot.counts_ticks and is_set(kind, name) and getattr(kind, name) % 1
    ]


def _check_window(fault: Any, duration: int, report: Report) -> None:
    has_start, has_finish = is_set(fault, "start"), is_set(fault, "finish")
    if has_start != has_finish:
        given, missing = ("start", "finish") if has_start else ("finish", "start")
        finding = f"has {given} but no {missing}; expected both, or neither in a pool"
        report.add(fault, "WindowComplete", f"{finding}; add {missing}")
    if fault.trigger is not None and not has_start:
        finding = (
            f"waits for trigger '{fault.trigger.ID}' but has no window; expected "
            "start and finish, or no trigger in a pool; correct one of them"
        )
        report.add(fault, "TriggerInWindow", finding)
    if not (has_start and has_finish):
        return
    if exchanged_window(fault):
        finding = f"starts at {fault.start} and finishes at {fault.finish}"
        report.add(fault, "WindowOrdered", f"{finding}; expected start <= finish; exchange them")
    elif fault.start >= duration:
        finding = (
            f"starts at {fault.start} in a mission of {duration} ticks and is never active; "
            "expected an earlier start; correct one of them"
        )
        report.add(fault, "WindowInsideMission", finding)


_AREA = "area or at"
_EVENTS: Mapping[str, tuple[str, ...]] = {
    "VIOLATED": ("goal",),
    "REACHED": ("goal",),
    "ENTERED": ("robot", _AREA),
    "EFFECT": ("faults",),
}
"""Features that a trigger of each event sets; EFFECT without faults is valid but never happens."""

_REACHABLE = ("GatherSamples", "Visit", "Track")


def fits_event(trigger: Any) -> bool:
    """Return whether a trigger refers to exactly what its event needs."""
    event, names = trigger.event.name, _given_to(trigger)
    given = tuple(_AREA if name in ("area", "at") else name for name in names)
    return given == _EVENTS.get(event) or (event == "EFFECT" and not given)


def _given_to(trigger: Any) -> tuple[str, ...]:
    known = ("goal", "robot", "area", "at", "faults")
    return tuple(name for name in known if getattr(trigger, name))


def _check_trigger(trigger: Any, report: Report) -> None:
    event = trigger.event.name
    if not fits_event(trigger):
        given, wanted = _given_to(trigger), _EVENTS.get(event, ())
        finding = (
            f"is {event} and has {' and '.join(given) or 'nothing'}; expected "
            f"{' and '.join(wanted) or 'another event'}, and nothing else; correct it"
        )
        report.add(trigger, "TriggerOfEvent", finding)
    elif event == "REACHED":
        task = trigger.goal.task.eClass
        if not any(is_kind(task, name) for name in _REACHABLE):
            finding = (
                f"waits until goal '{trigger.goal.ID}' is reached, but {task.name} cannot be "
                f"reached; expected a goal of {', '.join(_REACHABLE)}; choose another"
            )
            report.add(trigger, "ReachableGoal", finding)
    elif event == "EFFECT" and all(fault.trigger is trigger for fault in trigger.faults):
        finding = "waits only for faults that wait for it, so it never happens"
        report.add(trigger, "TriggerCanHappen", f"{finding}; expected another fault; add one")


def _check_parameters(kind: Any, report: Report) -> None:
    drawn = [("RandomBoundsOrdered", *pair) for pair in exchanged_draw(kind)]
    searched = [("SearchBoundsOrdered", *pair) for pair in exchanged_bounds(kind)]
    for constraint, low, high in drawn + searched:
        lowest, highest = number(getattr(kind, low)), number(getattr(kind, high))
        finding = f"has {low} {lowest} above {high} {highest}; expected the lower one first"
        report.add(kind, constraint, f"{finding}; exchange them")
    for name in broken_ticks(kind):
        finding = f"has {name} {number(getattr(kind, name))}; expected a whole number of ticks"
        report.add(kind, "WholeTicks", f"{finding}; round it")


def _check_fault_field(kind: Any, report: Report) -> None:
    message = getattr(kind, "affectedMessage", None)
    if message is None:
        return
    carried = [entry.name for entry in message.body]
    for affected in meaning(kind).properties:
        is_other = any(name not in {known.name for known in OF_ROBOT} for name in carried)
        carries = affected is not Field.COUNT or is_other  # rates and costs need no message
        if affected in OF_ROBOT:
            carries = affected.name in carried
        if not carries:
            wanted = affected.name
            finding = (
                f"falsifies {wanted}, but message '{message.ID}' carries {', '.join(carried)}, so "
                f"that the fault has no effect; expected a message with {wanted}; choose another"
            )
            report.add(kind, "FaultFieldCarried", finding)


def check_identities(tree: ModelTree, report: Report, *, become_names: bool) -> None:
    """Check the IDs of one file.

    ``become_names`` is whether they become names in Python: those of a mission do, except of
    requirements; those of faults do not.
    """
    named: dict[str, Node] = {}
    for text, node in tree.by_id.items():
        becomes_name = become_names and not is_kind(node.metaclass, "Requirement")
        defects = [*defects_of_id(text, becomes_name=becomes_name)]
        for defect in defects:
            report.add(node, defect.constraint, defect.finding)
        is_nameless = any(defect.constraint in ("IdSyntax", "ReservedId") for defect in defects)
        if is_nameless or not becomes_name:
            continue
        name = identifier(text)
        first = named.setdefault(name, node)
        if first is not node:
            finding = f"and {first.description} (line {first.line}) both become '{name}' in Python"
            report.add(node, "IdClash", f"{finding}; rename one")


def defects_of_id(text: str, *, becomes_name: bool) -> Iterator[Defect]:
    """Yield the defects of an ID by itself, without regard to other IDs."""
    if not re.fullmatch(r"[A-Za-z][A-Za-z0-9_. -]*", text):
        finding = f"has ID {shown(text)}; expected a letter, then letters, digits, '_', '-', '.'"
        yield Defect("IdSyntax", f"{finding} or spaces; rename it")
        return
    if " " in text:
        finding = f"has the ID {shown(text)} with spaces, which separate IDs in a list"
        yield Defect("IdWithoutSpaces", f"{finding} of references; expected none; use '_' or '-'")
    try:
        if becomes_name:
            identifier(text)
    except ModelError:
        finding = f"has ID {shown(text)}, a name that Python or generated code uses itself"
        yield Defect("ReservedId", f"{finding}; expected another; rename it")
