"""Write models in the format that was published for the paper's prototype.

The writer goes by the description of that format and shares nothing with the importer.
"""

from typing import Any

from lxml import etree

from m2t.models.load import LoadedModels

_XMI = "{http://www.omg.org/XMI}"
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
    namespaces = {"xmi": _XMI[1:-1], "setup": "acs_project_setup"}
    root = etree.Element("{acs_project_setup}Setup", nsmap=namespaces)
    root.attrib.update({f"{_XMI}version": "2.0", f"{_XMI}id": "_setup"})
    _add_mission(root, models.mission)
    if models.faults is not None:
        specification = _add(root, "specification", ID=models.faults.ID)
        for fault in models.faults.faults:
            _add_fault_type(_add(specification, "faults", name=fault.name), fault)
    etree.indent(root)
    return etree.tostring(root, encoding="ASCII", xml_declaration=True).decode("ascii")


def xmi_id(element: Any) -> str:
    """Return the xmi:id that an element with an ID has in a published file."""
    return f"_x{element.ID.encode('ascii').hex()}Q"


def _add(parent: Any, tag: str, element: Any = None, **given: Any) -> Any:
    """Add an element with what is given of its attributes."""
    n_before = sum(1 for _ in parent.getroottree().iter())
    identity = f"_a{n_before}Q" if element is None else xmi_id(element)
    texts = {name: str(value) for name, value in given.items() if value is not None}
    return etree.SubElement(parent, tag, {f"{_XMI}id": identity, **texts})


def _add_mission(root: Any, mission: Any) -> None:
    added = _add(root, "mission", name=mission.name, duration=f"{mission.duration}.0")
    for robot in mission.robots:
        _add_robot(added, robot)
    for server in mission.servers:
        _add_properties(_add(added, "servers", server, name=server.name, ID=server.ID), server)
    for goal in mission.goals:
        _add_goal(added, goal)
    for obstacle in mission.obstacles:
        _add_area(_add(added, "obstacles", obstacle, ID=obstacle.ID), "area", obstacle.area)
    _add_area(added, "missionArea", mission.missionArea)


def _add_robot(parent: Any, robot: Any) -> None:
    added = _add(parent, "robots", robot, name=robot.name, ID=robot.ID, speed=robot.speed)
    _add_point(added, "position", robot.position)
    _add_properties(added, robot)
    for tag, names in _COMPONENTS.items():
        for part in robot.eGet(tag):
            given = {name: part.eGet(name) for name in names}
            if "type" in given:
                kind = given["type"].name
                given["type"] = None if kind == "GPS_POSITION" else kind
            _add(added, tag, part, name=part.name, ID=part.ID, parentID=robot.ID, **given)


def _add_goal(parent: Any, goal: Any) -> None:
    added = _add(parent, "goals", goal, ID=goal.ID, name=goal.name)
    _add(added, "members", goalMembers=_references(goal.members))
    if goal.dependentGoals:
        _add(added, "dependentGoals", dependencies=_references(goal.dependentGoals))
    if goal.area is not None:
        _add_area(_add(added, "area"), "goalArea", goal.area)
    _add_task(_add(added, "task"), goal.task)
    for message in goal.messages:
        ends = {"from": xmi_id(message.sender), "to": xmi_id(message.receiver)}
        given = {"ID": message.ID, "goal_ID": goal.ID, "header": message.header, **ends}
        sent = _add(added, "messages", message, **given)
        for entry in message.body:
            _add(sent, "body", name=entry.name, type=entry.type)


def _add_task(parent: Any, task: Any) -> None:
    name = task.eClass.name
    given: dict[str, Any] = {}
    if name == "AvoidCollision":
        given = {"robots": _references(task.robots), "obstacles": _references(task.obstacles)}
    elif name == "GatherSamples":
        number, sensor = task.targetSampleNumber, xmi_id(task.sensor)
        given = {"targetSampleNumber": number, "sensor": sensor}
    elif name == "FixedDistanceBetweenRobots":
        given = {"fixedDistance": task.fixedDistance}
    added = _add(parent, name[0].lower() + name[1:], **given)
    if name in ("Patrol", "Stay"):
        _add_area(added, "area", task.area)
    if name == "Visit":
        _add_point(added, "coordinates", task.coordinates)
    for point in task.trajectory if name == "Track" else ():
        _add_point(added, "trajectory", point)
    if not given and not len(added):
        added.text = ""  # an end tag of its own


def _add_fault_type(parent: Any, fault: Any) -> None:
    for feature in fault.eClass.eStructuralFeatures:
        kind = fault.eGet(feature)
        if not feature.eType.name[0].isupper() or not hasattr(kind, "eClass"):
            continue
        given: dict[str, Any] = {}
        for name in (*_PARAMETERS, *_AFFECTED):
            if kind.eClass.findEStructuralFeature(name) is not None:
                value = kind.eGet(name)
                given[name] = xmi_id(value) if name in _AFFECTED else value
        _add(parent, feature.name, **given)


def _add_properties(parent: Any, station: Any) -> None:
    for name in _PROPERTIES:
        for entry in station.eGet(name):
            _add(parent, name, name=entry.name, value=entry.value)


def _add_area(parent: Any, tag: str, area: Any) -> None:
    _add_point(_add(parent, tag, area, ID=area.ID, radius=area.radius), "center", area.center)


def _add_point(parent: Any, tag: str, point: Any) -> None:
    if point is not None:
        _add(parent, tag, **{axis: point.eGet(axis) for axis in "xyz" if point.eGet(axis)})


def _references(elements: Any) -> str:
    return " ".join(xmi_id(element) for element in elements)
