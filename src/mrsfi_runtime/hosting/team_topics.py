"""The topics of a team, named after its robots and sensors in the same way in all missions.

docs/bus.md says what they carry.
"""

from dataclasses import dataclass

from mrsfi_runtime.transport.topics import Topic


@dataclass(frozen=True, slots=True)
class RobotTopics:
    """Topics of a robot.

    Attributes
    ----------
    robot
        Its ID in the model, as an identifier.
    """

    robot: str

    @property
    def position(self) -> Topic:
        """Return the topic of where it says it is."""
        return Topic(f"/{self.robot}/position", "geometry_msgs/Point")

    @property
    def speed(self) -> Topic:
        """Return the topic of its speed."""
        return Topic(f"/{self.robot}/speed", "std_msgs/Float64")

    @property
    def energy(self) -> Topic:
        """Return the topic of the energy that it has left."""
        return Topic(f"/{self.robot}/energy", "std_msgs/Float64")

    @property
    def truth(self) -> Topic:
        """Return the topic of its true state, which the collective intelligence never reads."""
        return Topic(f"/truth/{self.robot}", "std_msgs/Float64MultiArray")

    @property
    def heading_command(self) -> Topic:
        """Return the topic of the command that turns it."""
        return Topic(f"/{self.robot}/command/heading", "geometry_msgs/Vector3")

    @property
    def speed_command(self) -> Topic:
        """Return the topic of the command that sets its speed."""
        return Topic(f"/{self.robot}/command/speed", "std_msgs/Float64")


@dataclass(frozen=True, slots=True)
class SensorTopics:
    """Topics of a sensor.

    Attributes
    ----------
    robot, sensor
        The IDs of its robot and its own in the model, as identifiers.
    """

    robot: str
    sensor: str

    @property
    def samples(self) -> Topic:
        """Return the topic of how many samples it has taken."""
        return Topic(f"/{self.robot}/{self.sensor}/samples", "std_msgs/Int64")

    @property
    def active(self) -> Topic:
        """Return the topic of whether it is on."""
        return Topic(f"/{self.robot}/{self.sensor}/active", "std_msgs/Bool")

    @property
    def active_command(self) -> Topic:
        """Return the topic of the command that switches it."""
        return Topic(f"/{self.robot}/{self.sensor}/command/active", "std_msgs/Bool")
