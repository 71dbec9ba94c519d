"""Visitor of ``topics.py``: the robots and sensors after which topics are named."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import PurePosixPath
from typing import Any

from m2t.environment import Call
from m2t.naming import constant, identifier
from m2t.visitors.base import ModelVisitor


@dataclass(frozen=True, slots=True)
class SensorView:
    """A sensor: its identifier, constant, and index over all robots."""

    name: str
    constant: str
    index: int


@dataclass(frozen=True, slots=True)
class RobotView:
    """A robot: its identifier, constant, index, display name, and its sensors."""

    name: str
    constant: str
    index: int
    display_name: str
    sensors: tuple[SensorView, ...]


def robot_views(mission: Any) -> tuple[RobotView, ...]:
    """Return the robots of a mission with their sensors, in model order."""
    views: list[RobotView] = []
    n_sensors = 0
    for index, robot in enumerate(mission.robots):
        sensors = tuple(
            SensorView(identifier(sensor.ID), constant(sensor.ID), n_sensors + offset)
            for offset, sensor in enumerate(robot.sensors)
        )
        n_sensors += len(sensors)
        name = identifier(robot.ID)
        views.append(RobotView(name, constant(robot.ID), index, robot.name, sensors))
    return tuple(views)


class TopicsVisitor(ModelVisitor):
    """Collect a row for each robot and each sensor."""

    template = "topics.py.j2"
    target = PurePosixPath("topics.py")

    def visit_Mission(self, mission: Any) -> Mapping[str, Any]:
        """Return the template context of one mission."""
        robots = robot_views(mission)
        return {
            "robots": tuple(_row("RobotTopics", robot=robot.name) for robot in robots),
            "sensors": tuple(
                _row("SensorTopics", robot=robot.name, sensor=sensor.name)
                for robot in robots
                for sensor in robot.sensors
            ),
        }


def _row(kind: str, **names: str) -> Call:
    return Call(kind, tuple(names.items()), is_flat=True)
