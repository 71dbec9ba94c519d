"""Reads what a simulation has to know from the model of a mission, ``mission.xmi``.

Elements and attributes are those of ``metamodels/mission.ecore``, which also has their defaults.
Robots and sensors get the names of the topics in docs/bus.md.
"""

import math
import re
from pathlib import Path
from xml.etree import ElementTree as ET
from xml.etree.ElementTree import Element

from robots import Mission, Obstacle, Place, Robot, Sensor, WorldError


def read_mission(path: Path) -> Mission:
    """Return the mission of a model, or of the folder that the model is in.

    A model that is missing, or that lacks what a simulation needs, raises ``WorldError``.
    """
    file = path / "mission.xmi" if path.is_dir() else path
    try:
        root = ET.parse(file).getroot()
        robots = [_robot(each) for each in _parts(root, "robots")]
        obstacles = [_obstacle(each) for each in _parts(root, "obstacles")]
    except (OSError, ET.ParseError, WorldError) as error:
        raise WorldError(f"{file}: {error}") from error
    if not robots:
        raise WorldError(f"{file}: no robots; expected the model of a mission")
    return Mission(file.absolute().parent.name, robots, obstacles)


def _robot(element: Element) -> Robot:
    speed = _number(element, "speed")
    robot = Robot(
        _name(element),
        _place(element.find("position")),
        sum(_number(each, "totalEnergy") for each in _parts(element, "batteries")),
        sum(_number(each, "energyPerDistanceUnit") for each in _parts(element, "motionSources")),
        _number(element, "maxSpeed", 2.0 * speed),
        [_sensor(each) for each in _parts(element, "sensors")],
        _number(element, "radius", 1.0),
        _number(element, "positionNoise", 0.0),
    )
    robot.reset()
    return robot


def _sensor(element: Element) -> Sensor:
    return Sensor(
        _name(element),
        int(_number(element, "samplesPerSecond")),
        _number(element, "energyPerSample", 0.0),
        element.get("type") == "GPS_POSITION",
    )


def _obstacle(element: Element) -> Obstacle:
    name = _name(element)
    (area,) = _parts(element, "area") or [Element("area", ID=name)]
    corners = tuple(_place(each) for each in area.findall("corners"))
    radius = 0.0 if corners else _number(area, "radius")
    return Obstacle(name, _place(area.find("center")), radius, corners)


def _parts(element: Element, feature: str) -> list[Element]:
    parts = element.findall(feature)
    if any("href" in each.attrib for each in parts):
        raise WorldError(f"{feature} are in another file; expected them here")
    return parts


def _name(element: Element) -> str:
    """Return the ID as it stands in the names of topics."""
    name = re.sub(r"[_. -]+", "_", element.get("ID", "")).strip("_").lower()
    if not name:
        raise WorldError(f"an element of {element.tag} has no ID")
    return name


def _place(element: Element | None) -> Place:
    if element is None:
        return 0.0, 0.0, 0.0
    return _number(element, "x", 0.0), _number(element, "y", 0.0), _number(element, "z", 0.0)


def _number(element: Element, feature: str, default: float | None = None) -> float:
    text = element.get(feature)
    if text is None and default is not None:
        return default
    try:
        number = float(text or "")
    except ValueError:
        number = math.nan
    if not math.isfinite(number):
        found = "missing" if text is None else repr(text)
        where = " ".join([element.tag, *filter(None, [element.get("ID")])])
        raise WorldError(f"{where}: {feature} is {found}; expected a number")
    return number
