# Generated from mission depot by simulation.py.j2.
# Edit inside protected regions only.
"""The simulation: moves the true state of the mission and publishes it."""

from mrsfi_runtime.api import (
    Mission,
    PubSub,
    SimulatedRobot,
    SimulatedSensor,
    initial_state,
    move,
)

from .topics import ROBOTS, SENSORS


class Simulation:
    """The mission's side of the bus: publishes every topic and obeys every command."""

    def __init__(self, transport: PubSub, mission: Mission) -> None:
        self.mission = mission
        self.world = world = initial_state(mission, 0)
        self.robots = tuple(
            SimulatedRobot(transport, topics, world, index) for index, topics in enumerate(ROBOTS)
        )
        self.sensors = tuple(
            SimulatedSensor(transport, topics, world, index) for index, topics in enumerate(SENSORS)
        )

    def reset(self, seed: int) -> None:
        """Go back to before the first tick."""
        self.world = initial_state(self.mission, seed)
        for robot in self.robots:
            robot.reset(self.world)
        for sensor in self.sensors:
            sensor.reset(self.world)

    def step(self, tick: int) -> None:
        """Fly one tick and publish the result."""
        move(self.world, tick)
        for robot in self.robots:
            robot.publish()
        for sensor in self.sensors:
            sensor.publish()

    def publish_truth(self) -> None:
        """Publish what is true of every robot and its sensors, for the judge alone."""
        for robot in self.robots:
            robot.publish_truth()
