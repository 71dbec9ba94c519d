"""What a generated simulation interface is made of: one part per robot and per sensor.

References
----------
Source paper, section III-F.
"""

from mrsfi_runtime.cosimulation.heard import Heard
from mrsfi_runtime.cosimulation.team_topics import RobotTopics, SensorTopics
from mrsfi_runtime.errors import ProtocolError
from mrsfi_runtime.kernel.state import RobotState, SensorState
from mrsfi_runtime.transport.topics import PubSub


class RobotInterface:
    """Hears what the simulation publishes about a robot, and commands it."""

    def __init__(self, transport: PubSub, topics: RobotTopics) -> None:
        self._position = Heard(transport, topics.position)
        self._speed = Heard(transport, topics.speed)
        self._energy = Heard(transport, topics.energy)
        self._turn = transport.advertise(topics.heading_command)
        self._drive = transport.advertise(topics.speed_command)

    def reset(self) -> None:
        """Forget what was received."""
        self._position.forget()
        self._speed.forget()
        self._energy.forget()

    def read(self, robot: RobotState) -> None:
        """Copy what came in this tick; a position that it did not tell stays as it was."""
        if self._position.is_new:
            position = self._position.take()
            robot.x = float(position["x"])
            robot.y = float(position["y"])
            robot.z = float(position["z"])
        robot.speed = float(self._speed.take()["data"])
        robot.energy = float(self._energy.take()["data"])

    def require_position(self, *, is_due: bool) -> None:
        """Raise ``ProtocolError`` unless it told its position if and only if that is due."""
        if self._position.is_new and not is_due:
            raise ProtocolError(
                f"a message on {self._position.name} while the robot's GPS_POSITION sensor is off; "
                "expected none (docs/bus.md)"
            )
        if is_due and not self._position.is_new:
            raise self._position.missing()

    def set_heading(self, x: float, y: float) -> None:
        """Turn the robot to a unit heading."""
        self._turn({"x": x, "y": y, "z": 0.0})

    def set_speed(self, speed: float) -> None:
        """Set its speed."""
        self._drive({"data": speed})


class SensorInterface:
    """Hears what the simulation publishes about a sensor, and switches it."""

    def __init__(self, transport: PubSub, topics: SensorTopics) -> None:
        self._samples = Heard(transport, topics.samples)
        self._active = Heard(transport, topics.active)
        self._told: bool | None = None
        self._switch = transport.advertise(topics.active_command)

    def reset(self) -> None:
        """Forget what was received."""
        self._samples.forget()
        self._active.forget()
        self._told = None

    def read(self, sensor: SensorState) -> None:
        """Copy what came in this tick; whether it is active stays as it was told."""
        count = int(self._samples.take()["data"])
        if count < sensor.count:
            raise ProtocolError(
                f"{self._samples.name} carried {count} after {sensor.count}; a count never falls"
            )
        sensor.count = count
        sensor.active = int(self._last_active())

    def require_active(self, is_active: int) -> None:
        """Raise ``ProtocolError`` unless it told last whether it is active now."""
        if self._last_active() != is_active:
            raise ProtocolError(
                f"{self._active.name} said {self._told} last, and the true state says "
                f"{bool(is_active)}; it has to speak whenever that changes (docs/bus.md)"
            )

    def set_active(self, active: bool) -> None:
        """Switch the sensor on or off."""
        self._switch({"data": active})

    def _last_active(self) -> bool:
        """Return what it told last, at the latest in this tick."""
        if self._active.is_new or self._told is None:
            self._told = bool(self._active.take()["data"])
        return self._told
