"""The topics of a team, named after its robots and sensors in the same way in all missions.

docs/bus.md says what they carry.
"""

from mrsfi_runtime.transport.topics import Topic


class RobotTopics:
    """Topics of a robot, by its identifier: what is said of it, what is true, its commands."""

    def __init__(self, robot: str) -> None:
        self.position = Topic(f"/{robot}/position", "geometry_msgs/Point")
        self.speed = Topic(f"/{robot}/speed", "std_msgs/Float64")
        self.energy = Topic(f"/{robot}/energy", "std_msgs/Float64")
        self.truth = Topic(f"/truth/{robot}", "std_msgs/Float64MultiArray")
        self.heading_command = Topic(f"/{robot}/command/heading", "geometry_msgs/Vector3")
        self.speed_command = Topic(f"/{robot}/command/speed", "std_msgs/Float64")


class SensorTopics:
    """Topics of a sensor, by two identifiers: what the simulation says of it, and its switch."""

    def __init__(self, robot: str, sensor: str) -> None:
        self.samples = Topic(f"/{robot}/{sensor}/samples", "std_msgs/Int64")
        self.active = Topic(f"/{robot}/{sensor}/active", "std_msgs/Bool")
        self.active_command = Topic(f"/{robot}/{sensor}/command/active", "std_msgs/Bool")
