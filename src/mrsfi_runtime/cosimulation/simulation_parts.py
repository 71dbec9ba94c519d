"""What a generated simulation is made of: one part per robot and per sensor.

References
----------
Source paper, section III-F.
"""

from mrsfi_runtime.cosimulation.team_topics import RobotTopics, SensorTopics
from mrsfi_runtime.cosimulation.truth import true_values
from mrsfi_runtime.kernel.commands import reported_place, reports_position
from mrsfi_runtime.kernel.state import State
from mrsfi_runtime.transport.topics import Payload, PubSub


class SimulatedRobot:
    """Publishes a robot of the true state, at a place in it, and has it obey its commands."""

    def __init__(self, transport: PubSub, topics: RobotTopics, world: State, index: int) -> None:
        self._index = index
        self.reset(world)
        self._tell_position = transport.advertise(topics.position)
        self._tell_speed = transport.advertise(topics.speed)
        self._tell_energy = transport.advertise(topics.energy)
        self._tell_truth = transport.advertise(topics.truth)
        transport.subscribe(topics.heading_command, self._on_heading)
        transport.subscribe(topics.speed_command, self._on_speed)

    def reset(self, world: State) -> None:
        """Begin a run with another true state."""
        self._world = world
        self._robot = world.robots[self._index]
        self._command = world.commands[self._index]

    def publish(self) -> None:
        """Publish the robot; its position only while it knows it."""
        robot = self._robot
        if reports_position(self._world, self._index):
            x, y = reported_place(self._world, self._index)
            self._tell_position({"x": x, "y": y, "z": robot.z})
        self._tell_speed({"data": robot.speed})
        self._tell_energy({"data": robot.energy})

    def publish_truth(self) -> None:
        """Publish what is true of the robot and its sensors, for the judge alone."""
        self._tell_truth({"data": true_values(self._world, self._index)})

    def _on_heading(self, payload: Payload) -> None:
        self._command.heading_x = float(payload["x"])
        self._command.heading_y = float(payload["y"])

    def _on_speed(self, payload: Payload) -> None:
        self._command.speed = float(payload["data"])


class SimulatedSensor:
    """Publishes a sensor of the true state, at a place in it, and has it obey its switch."""

    def __init__(self, transport: PubSub, topics: SensorTopics, world: State, index: int) -> None:
        self._index = index
        self.reset(world)
        self._tell_samples = transport.advertise(topics.samples)
        self._tell_active = transport.advertise(topics.active)
        transport.subscribe(topics.active_command, self._on_active)

    def reset(self, world: State) -> None:
        """Begin a run with another true state."""
        self._sensor = world.sensors[self._index]
        self._switch = world.switches[self._index]
        self._told_active = -1

    def publish(self) -> None:
        """Publish the sensor; whether it is active only when that changed."""
        sensor = self._sensor
        self._tell_samples({"data": sensor.count})
        if sensor.active != self._told_active:
            self._told_active = sensor.active
            self._tell_active({"data": sensor.active == 1})

    def _on_active(self, payload: Payload) -> None:
        self._switch.active = int(payload["data"])
