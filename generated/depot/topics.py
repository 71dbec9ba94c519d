# Generated from mission depot by topics.py.j2.
# Edit inside protected regions only.
"""The team on the bus, one row per robot and sensor: their topics are named after them."""

from mrsfi_runtime.api import RobotTopics, SensorTopics

ROBOTS: tuple[RobotTopics, ...] = (
    RobotTopics(robot="ada"),
    RobotTopics(robot="ben"),
    RobotTopics(robot="cleo"),
    RobotTopics(robot="dan"),
)

SENSORS: tuple[SensorTopics, ...] = (
    SensorTopics(robot="ada", sensor="ada_positioning"),
    SensorTopics(robot="ben", sensor="ben_positioning"),
    SensorTopics(robot="cleo", sensor="cleo_positioning"),
    SensorTopics(robot="dan", sensor="dan_positioning"),
    SensorTopics(robot="dan", sensor="dan_thermometer"),
)
