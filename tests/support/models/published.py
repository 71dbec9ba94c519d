"""Write models in the format that was published for the paper's prototype.

The writer goes by the description of that format and shares nothing with the importer.
"""

from typing import Any
from xml.sax.saxutils import quoteattr

from m2t.load import LoadedModels

_HEAD = (
    '<?xml version="1.0" encoding="ASCII"?>\n'
    '<setup:Setup xmi:version="2.0" xmlns:xmi="http://www.omg.org/XMI" '
    'xmlns:setup="acs_project_setup" xmi:id="_setup">\n'
)
_PROPERTIES = ("intProperties", "stringProperties", "doubleProperties")
_COMPONENTS = {
    "sensors": ("energyPerSample", "samplesPerSecond", "type"),
    "batteries": ("totalEnergy",),
    "motionSources": ("energyPerDistanceUnit",),
}
_PARAMETERS = (
    *("DELAY", "BLOCK_DURATION", "LOWER_BOUND", "UPPER_BOUND", "FIXED_VAL", "PERCENTAGE", "VAL"),
    *("NEW_X", "NEW_Y", "NEW_Z"),
)
_AFFECTED = ("affectedMessage", "affectedRobot", "affectedSensor", "affectedObstacle")


def published(models: LoadedModels) -> str:
    """Return a mission and its faults as the text of a published file."""
    writer = _Published()
    writer.mission(models.mission)
    if models.faults is not None:
        writer.specification(models.faults)
    return _HEAD + "".join(writer.lines) + "</setup:Setup>\n"


def xmi_id(element: Any) -> str:
    """Return the xmi:id that an element with an ID has in a published file."""
    return f"_x{element.ID.encode('ascii').hex()}Q"


class _Published:
    def __init__(self) -> None:
        self.lines: list[str] = []
        self._depth = 1
        self._n_anonymous = 0

    def mission(self, mission: Any) -> None:
        duration = f"{mission.duration}.0"
        self._open("mission", None, name=mission.name, duration=duration)
        for robot in mission.robots:
            self._robot(robot)
        for server in mission.servers:
            self._open("servers", server, name=server.name, ID=server.ID)
            self._properties(server)
            self._close("servers")
        for goal in mission.goals:
            self._goal(goal)
        for obstacle in mission.obstacles:
            self._open("obstacles", obstacle, ID=obstacle.ID)
            self._area("area", obstacle.area)
            self._close("obstacles")
        self._area("missionArea", mission.missionArea)
        self._close("mission")

    def specification(self, faults: Any) -> None:
        self._open("specification", None, ID=faults.ID)
        for fault in faults.faults:
            self._open("faults", None, name=fault.name)
            self._fault_type(fault)
            self._close("faults")
        self._close("specification")

    def _robot(self, robot: Any) -> None:
        self._open("robots", robot, name=robot.name, ID=robot.ID, speed=robot.speed)
        self._point("position", robot.position)
        self._properties(robot)
        for tag, names in _COMPONENTS.items():
            for part in robot.eGet(tag):
                given = {name: part.eGet(name) for name in names}
                if "type" in given:
                    kind = given["type"].name
                    given["type"] = None if kind == "GPS_POSITION" else kind
                self._leaf(tag, part, name=part.name, ID=part.ID, parentID=robot.ID, **given)
        self._close("robots")

    def _goal(self, goal: Any) -> None:
        self._open("goals", goal, ID=goal.ID, name=goal.name)
        self._leaf("members", None, goalMembers=_references(goal.members))
        if goal.dependentGoals:
            self._leaf("dependentGoals", None, dependencies=_references(goal.dependentGoals))
        if goal.area is not None:
            self._open("area", None)
            self._area("goalArea", goal.area)
            self._close("area")
        self._open("task", None)
        self._task(goal.task)
        self._close("task")
        for message in goal.messages:
            self._open(
                "messages",
                message,
                ID=message.ID,
                goal_ID=goal.ID,
                header=message.header,
                **{"from": xmi_id(message.sender), "to": xmi_id(message.receiver)},
            )
            for entry in message.body:
                self._leaf("body", None, name=entry.name, type=entry.type)
            self._close("messages")
        self._close("goals")

    def _task(self, task: Any) -> None:
        name = task.eClass.name
        tag = name[0].lower() + name[1:]
        if name == "AvoidCollision":
            robots, obstacles = _references(task.robots), _references(task.obstacles)
            self._leaf(tag, None, robots=robots, obstacles=obstacles)
        elif name == "GatherSamples":
            number, sensor = task.targetSampleNumber, xmi_id(task.sensor)
            self._leaf(tag, None, targetSampleNumber=number, sensor=sensor)
        elif name == "FixedDistanceBetweenRobots":
            self._leaf(tag, None, fixedDistance=task.fixedDistance)
        else:
            self._open(tag, None)
            if name in ("Patrol", "Stay"):
                self._area("area", task.area)
            if name == "Visit":
                self._point("coordinates", task.coordinates)
            for point in task.trajectory if name == "Track" else ():
                self._point("trajectory", point)
            self._close(tag)

    def _fault_type(self, fault: Any) -> None:
        for feature in fault.eClass.eStructuralFeatures:
            kind = fault.eGet(feature)
            if not feature.eType.name[0].isupper() or not hasattr(kind, "eClass"):
                continue
            given: dict[str, Any] = {}
            for name in (*_PARAMETERS, *_AFFECTED):
                if kind.eClass.findEStructuralFeature(name) is not None:
                    value = kind.eGet(name)
                    given[name] = xmi_id(value) if name in _AFFECTED else value
            self._leaf(feature.name, None, **given)

    def _properties(self, station: Any) -> None:
        for name in _PROPERTIES:
            for entry in station.eGet(name):
                self._leaf(name, None, name=entry.name, value=entry.value)

    def _area(self, tag: str, area: Any) -> None:
        self._open(tag, area, ID=area.ID, radius=area.radius)
        self._point("center", area.center)
        self._close(tag)

    def _point(self, tag: str, point: Any) -> None:
        if point is not None:
            given = {axis: point.eGet(axis) for axis in "xyz" if point.eGet(axis)}
            self._leaf(tag, None, **given)

    def _open(self, tag: str, element: Any, **given: Any) -> None:
        self._write(tag, element, given, ">")
        self._depth += 1

    def _close(self, tag: str) -> None:
        self._depth -= 1
        self.lines.append(f"{'  ' * self._depth}</{tag}>\n")

    def _leaf(self, tag: str, element: Any, **given: Any) -> None:
        self._write(tag, element, given, "/>")

    def _write(self, tag: str, element: Any, given: dict[str, Any], end: str) -> None:
        self._n_anonymous += 1
        identity = f"_a{self._n_anonymous}Q" if element is None else xmi_id(element)
        attributes = {"xmi:id": identity, **given}
        text = "".join(
            f" {name}={quoteattr(str(value))}"
            for name, value in attributes.items()
            if value is not None
        )
        self.lines.append(f"{'  ' * self._depth}<{tag}{text}{end}\n")


def _references(elements: Any) -> str:
    return " ".join(xmi_id(element) for element in elements)
