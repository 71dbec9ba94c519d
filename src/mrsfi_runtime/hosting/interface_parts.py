"""What a generated simulation interface is made of: one part per robot and per sensor.

References
----------
Source paper, section III-F.
"""

from typing import NoReturn

from mrsfi_runtime.hosting.team_topics import RobotTopics, SensorTopics
from mrsfi_runtime.kernel.state import RobotState, SensorState
from mrsfi_runtime.transport.topics import Payload, PubSub, Topic


class RobotInterface:
    """Hears what the simulation publishes about a robot, and commands it."""

    def __init__(self, transport: PubSub, topics: RobotTopics) -> None:
        self._position = _Newest(transport, topics.position)
        self._speed = _Newest(transport, topics.speed)
        self._energy = _Newest(transport, topics.energy)
        self._turn = transport.advertise(topics.heading_command)
        self._drive = transport.advertise(topics.speed_command)

    def reset(self) -> None:
        """Forget what was received."""
        self._position.forget()
        self._speed.forget()
        self._energy.forget()

    def read(self, robot: RobotState) -> None:
        """Copy the newest messages; a position that it never told stays as it was."""
        position = self._position.payload
        if position is not self._position.nothing:
            robot.x = float(position["x"])
            robot.y = float(position["y"])
            robot.z = float(position["z"])
        robot.speed = float(self._speed.payload["data"])
        robot.energy = float(self._energy.payload["data"])

    def set_heading(self, x: float, y: float) -> None:
        """Turn the robot to a unit heading."""
        self._turn({"x": x, "y": y, "z": 0.0})

    def set_speed(self, speed: float) -> None:
        """Set its speed."""
        self._drive({"data": speed})


class SensorInterface:
    """Hears what the simulation publishes about a sensor, and switches it."""

    def __init__(self, transport: PubSub, topics: SensorTopics) -> None:
        self._samples = _Newest(transport, topics.samples)
        self._active = _Newest(transport, topics.active)
        self._switch = transport.advertise(topics.active_command)

    def reset(self) -> None:
        """Forget what was received."""
        self._samples.forget()
        self._active.forget()

    def read(self, sensor: SensorState) -> None:
        """Copy the newest messages."""
        sensor.count = int(self._samples.payload["data"])
        sensor.active = int(bool(self._active.payload["data"]))

    def set_active(self, active: bool) -> None:
        """Switch the sensor on or off."""
        self._switch({"data": active})


class _Newest:
    """The newest message of a topic."""

    def __init__(self, transport: PubSub, topic: Topic) -> None:
        self.nothing = _Nothing(topic)
        self.payload: Payload = self.nothing
        transport.subscribe(topic, self._receive)

    def forget(self) -> None:
        """Be as before the first message."""
        self.payload = self.nothing

    def _receive(self, payload: Payload) -> None:
        self.payload = payload


class _Nothing(Payload):
    """In place of a message that never came: whoever reads it hears of its topic."""

    def __init__(self, topic: Topic) -> None:
        super().__init__()
        self._topic = topic

    def __missing__(self, field: str) -> NoReturn:
        raise KeyError(f"nothing on {self._topic.name}")
