# Generated from mission atlas_search by topics.py.j2.
# Edit inside protected regions only.
"""The team on the bus, one row per robot and sensor: their topics are named after them."""

from mrsfi_runtime.api import RobotTopics, SensorTopics

ROBOTS: tuple[RobotTopics, ...] = (
    RobotTopics(robot="frank"),
    RobotTopics(robot="henry"),
    RobotTopics(robot="ella"),
    RobotTopics(robot="gilda"),
)

SENSORS: tuple[SensorTopics, ...] = (
    SensorTopics(robot="frank", sensor="frank_gps"),
    SensorTopics(robot="henry", sensor="henry_gps"),
    SensorTopics(robot="ella", sensor="ella_gps"),
    SensorTopics(robot="gilda", sensor="gilda_gps"),
)
