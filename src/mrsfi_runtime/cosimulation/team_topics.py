"""The topics of a team, named after its robots and sensors in the same way in all missions.

docs/bus.md says what they carry.
"""

from mrsfi_runtime.transport.topics import Topic


class RobotTopics:
    """Topics of a robot: what the simulation says of it, what is true of it, and its commands.

    Parameters
    ----------
    robot
        Its ID in the model, as an identifier.
    """

    def __init__(self, robot: str) -> None:
        self.position = Topic(f"/{robot}/position", "geometry_msgs/Point")
        self.speed = Topic(f"/{robot}/speed", "std_msgs/Float64")
        self.energy = Topic(f"/{robot}/energy", "std_msgs/Float64")
        self.truth = Topic(f"/truth/{robot}", "std_msgs/Float64MultiArray")
        self.heading_command = Topic(f"/{robot}/command/heading", "geometry_msgs/Vector3")
        self.speed_command = Topic(f"/{robot}/command/speed", "std_msgs/Float64")


class SensorTopics:
    """Topics of a sensor: what the simulation says of it, and its switch.

    Parameters
    ----------
    robot, sensor
        The IDs of its robot and its own in the model, as identifiers.
    """

    def __init__(self, robot: str, sensor: str) -> None:
        self.samples = Topic(f"/{robot}/{sensor}/samples", "std_msgs/Int64")
        self.active = Topic(f"/{robot}/{sensor}/active", "std_msgs/Bool")
        self.active_command = Topic(f"/{robot}/{sensor}/command/active", "std_msgs/Bool")
