# Generated from mission undersea by topics.py.j2.
# Edit inside protected regions only.
"""The team on the bus, one row per robot and sensor: their topics are named after them."""

from mrsfi_runtime.api import RobotTopics, SensorTopics

ROBOTS: tuple[RobotTopics, ...] = (RobotTopics(robot="nautilus"),)

SENSORS: tuple[SensorTopics, ...] = (
    SensorTopics(robot="nautilus", sensor="sensor1"),
    SensorTopics(robot="nautilus", sensor="sensor2"),
    SensorTopics(robot="nautilus", sensor="sensor3"),
)
