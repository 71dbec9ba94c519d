"""What the two sides of a mission share: robots and sensors, and the topics named after them."""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from m2t.naming import constant, identifier
from m2t.visitors.base import ModelVisitor


@dataclass(frozen=True, slots=True)
class TopicView:
    """A topic and its message type."""

    name: str
    type: str


@dataclass(frozen=True, slots=True)
class SensorView:
    """A sensor: its identifier, constant, index over all robots, and the root of its topics."""

    name: str
    constant: str
    index: int
    root: str

    @property
    def samples_topic(self) -> str:
        """Topic of the cumulative number of samples."""
        return f"{self.root}/samples"

    @property
    def active_topic(self) -> str:
        """Topic of the activation."""
        return f"{self.root}/active"

    @property
    def active_command_topic(self) -> str:
        """Topic of the command that switches the sensor."""
        return f"{self.root}/command/active"


@dataclass(frozen=True, slots=True)
class RobotView:
    """A robot: its identifier, constant, index, display name, and its sensors."""

    name: str
    constant: str
    index: int
    display_name: str
    sensors: tuple[SensorView, ...]

    @property
    def position_topic(self) -> str:
        """Topic of the position."""
        return f"/{self.name}/position"

    @property
    def speed_topic(self) -> str:
        """Topic of the speed."""
        return f"/{self.name}/speed"

    @property
    def energy_topic(self) -> str:
        """Topic of the energy left."""
        return f"/{self.name}/energy"

    @property
    def truth_topic(self) -> str:
        """Topic of the true state, which only the judge of true verdicts reads."""
        return f"/truth/{self.name}"

    @property
    def heading_topic(self) -> str:
        """Topic of the command that turns the robot."""
        return f"/{self.name}/command/heading"

    @property
    def speed_command_topic(self) -> str:
        """Topic of the command that sets the speed."""
        return f"/{self.name}/command/speed"


def robot_views(mission: Any) -> tuple[RobotView, ...]:
    """Return the robots of a mission with their sensors, in model order."""
    views: list[RobotView] = []
    n_sensors = 0
    for index, robot in enumerate(mission.robots):
        name = identifier(robot.ID)
        sensors = tuple(
            SensorView(
                name=identifier(sensor.ID),
                constant=constant(sensor.ID),
                index=n_sensors + offset,
                root=f"/{name}/{identifier(sensor.ID)}",
            )
            for offset, sensor in enumerate(robot.sensors)
        )
        n_sensors += len(sensors)
        views.append(RobotView(name, constant(robot.ID), index, robot.name, sensors))
    return tuple(views)


class TopicVisitor(ModelVisitor):
    """Collect robots, sensors and topics: what both sides of a mission are made of."""

    def visit_Mission(self, mission: Any) -> Mapping[str, Any]:
        """Return the template context of one mission."""
        robots = robot_views(mission)
        return {
            "robots": robots,
            "sensors": tuple(sensor for robot in robots for sensor in robot.sensors),
            "topics": tuple(topic for robot in robots for topic in _topics(robot)),
            "commands": tuple(topic for robot in robots for topic in _commands(robot)),
        }


def _topics(robot: RobotView) -> Iterator[TopicView]:
    """Yield what the simulation publishes about a robot and its sensors."""
    yield TopicView(robot.position_topic, "geometry_msgs/Point")
    yield TopicView(robot.speed_topic, "std_msgs/Float64")
    yield TopicView(robot.energy_topic, "std_msgs/Float64")
    for sensor in robot.sensors:
        yield TopicView(sensor.samples_topic, "std_msgs/Int64")
        yield TopicView(sensor.active_topic, "std_msgs/Bool")


def _commands(robot: RobotView) -> Iterator[TopicView]:
    """Yield what the collective intelligence tells a robot and its sensors."""
    yield TopicView(robot.heading_topic, "geometry_msgs/Vector3")
    yield TopicView(robot.speed_command_topic, "std_msgs/Float64")
    for sensor in robot.sensors:
        yield TopicView(sensor.active_command_topic, "std_msgs/Bool")


def methods(
    robots: Iterable[RobotView], per_robot: Iterable[str], per_sensor: Iterable[str]
) -> tuple[str, ...]:
    """Return the generated methods of robots and sensors, in the order of topics.

    Parameters
    ----------
    robots
        Robots in model order.
    per_robot, per_sensor
        Patterns of method names with ``{}`` for the identifier.
    """
    robot_patterns, sensor_patterns = tuple(per_robot), tuple(per_sensor)
    found: list[str] = []
    for robot in robots:
        found += [f"self.{pattern.format(robot.name)}" for pattern in robot_patterns]
        for sensor in robot.sensors:
            found += [f"self.{pattern.format(sensor.name)}" for pattern in sensor_patterns]
    return tuple(found)
