# Generated from mission depot by sim_interface.py.j2.
# Edit inside protected regions only.
"""The simulation interface: what the collective intelligence hears and says."""

from mrsfi_runtime.api import PubSub, RobotInterface, SensorInterface, State

from .topics import ROBOTS, SENSORS


class SimInterface:
    """Getters for what the simulation publishes, setters for what it obeys, robot by robot."""

    def __init__(self, transport: PubSub) -> None:
        self.robots = tuple(RobotInterface(transport, topics) for topics in ROBOTS)
        self.sensors = tuple(SensorInterface(transport, topics) for topics in SENSORS)

    def reset(self) -> None:
        """Forget what was received."""
        for robot in self.robots:
            robot.reset()
        for sensor in self.sensors:
            sensor.reset()

    def read(self, inbox: State) -> None:
        """Copy the newest message of every topic into the inbox."""
        for robot, robot_state in zip(self.robots, inbox.robots, strict=True):
            robot.read(robot_state)
        for sensor, sensor_state in zip(self.sensors, inbox.sensors, strict=True):
            sensor.read(sensor_state)
