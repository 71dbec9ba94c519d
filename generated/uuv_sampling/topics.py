# Generated from mission uuv_sampling by topics.py.j2.
# Edit inside protected regions only.
"""The team on the bus, one row per robot and sensor: their topics are named after them."""

from mrsfi_runtime.api import RobotTopics, SensorTopics

ROBOTS: tuple[RobotTopics, ...] = (
    RobotTopics(robot="r1"),
    RobotTopics(robot="r2"),
    RobotTopics(robot="r3"),
)

SENSORS: tuple[SensorTopics, ...] = (
    SensorTopics(robot="r1", sensor="s1"),
    SensorTopics(robot="r1", sensor="s2"),
    SensorTopics(robot="r2", sensor="s3"),
    SensorTopics(robot="r2", sensor="s4"),
    SensorTopics(robot="r3", sensor="s5"),
    SensorTopics(robot="r3", sensor="s6"),
)
