# Generated from mission tight_margins by topics.py.j2.
# Edit inside protected regions only.
"""The team on the bus, one row per robot and sensor: their topics are named after them."""

from mrsfi_runtime.api import RobotTopics, SensorTopics

ROBOTS: tuple[RobotTopics, ...] = (
    RobotTopics(robot="p1"),
    RobotTopics(robot="p2"),
    RobotTopics(robot="p3"),
)

SENSORS: tuple[SensorTopics, ...] = (
    SensorTopics(robot="p1", sensor="p1_gps"),
    SensorTopics(robot="p1", sensor="p1_depth"),
    SensorTopics(robot="p2", sensor="p2_gps"),
    SensorTopics(robot="p2", sensor="p2_pressure"),
    SensorTopics(robot="p3", sensor="p3_gps"),
    SensorTopics(robot="p3", sensor="p3_temperature"),
)
