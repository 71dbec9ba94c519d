"""Visitor of ``topics.py``: the robots and sensors after which topics are named."""

from collections.abc import Mapping
from typing import Any

from m2t.environment import Call
from m2t.load import LoadedModels
from m2t.naming import identifier


def visit(models: LoadedModels) -> Mapping[str, Any]:
    """Collect a row for each robot and each sensor."""
    robots = models.mission.robots
    return {
        "robots": tuple(_row("RobotTopics", robot=robot.ID) for robot in robots),
        "sensors": tuple(
            _row("SensorTopics", robot=robot.ID, sensor=sensor.ID)
            for robot in robots
            for sensor in robot.sensors
        ),
    }


def _row(kind: str, **ids: str) -> Call:
    names = tuple((element, identifier(each)) for element, each in ids.items())
    return Call(kind, names, is_flat=True)
