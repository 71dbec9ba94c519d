# Generated from mission tight_energy by topics.py.j2.
# Edit inside protected regions only.
"""The team on the bus, one row per robot and sensor: their topics are named after them."""

from mrsfi_runtime.api import RobotTopics, SensorTopics

ROBOTS: tuple[RobotTopics, ...] = (
    RobotTopics(robot="e1"),
    RobotTopics(robot="e2"),
    RobotTopics(robot="e3"),
)

SENSORS: tuple[SensorTopics, ...] = (
    SensorTopics(robot="e1", sensor="e1_gps_position"),
    SensorTopics(robot="e1", sensor="e1_temperature"),
    SensorTopics(robot="e2", sensor="e2_gps_position"),
    SensorTopics(robot="e2", sensor="e2_depth"),
    SensorTopics(robot="e3", sensor="e3_gps_position"),
    SensorTopics(robot="e3", sensor="e3_pressure"),
)
