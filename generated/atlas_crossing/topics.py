# Generated from mission atlas_crossing by topics.py.j2.
# Edit inside protected regions only.
"""The team on the bus, one row per robot and sensor: their topics are named after them."""

from mrsfi_runtime.api import RobotTopics, SensorTopics

ROBOTS: tuple[RobotTopics, ...] = (
    RobotTopics(robot="gilda"),
    RobotTopics(robot="henry"),
)

SENSORS: tuple[SensorTopics, ...] = (
    SensorTopics(robot="gilda", sensor="gilda_gps"),
    SensorTopics(robot="henry", sensor="henry_gps"),
)
