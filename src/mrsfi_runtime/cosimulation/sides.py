"""What the hosts expect of generated code: a simulation and an interface."""

from typing import Protocol

from mrsfi_runtime.cosimulation.interface_parts import RobotInterface, SensorInterface
from mrsfi_runtime.kernel.state import State
from mrsfi_runtime.model.mission import Mission
from mrsfi_runtime.transport.topics import PubSub


class Simulation(Protocol):
    """A generated simulation: moves the true state and publishes it."""

    world: State

    def __init__(self, transport: PubSub, mission: Mission) -> None: ...

    def reset(self, seed: int) -> None:
        """Go back to before the first tick."""

    def step(self, tick: int) -> None:
        """Fly one tick and publish the result."""

    def publish_truth(self) -> None:
        """Publish the true state, for the judge alone."""


class SimInterface(Protocol):
    """A generated simulation interface: getters and setters of the robots and sensors."""

    @property
    def robots(self) -> tuple[RobotInterface, ...]:
        """What is heard of each robot, and told it."""

    @property
    def sensors(self) -> tuple[SensorInterface, ...]:
        """What is heard of each sensor, and told it."""

    def __init__(self, transport: PubSub) -> None: ...

    def reset(self) -> None:
        """Forget what was received."""

    def read(self, inbox: State) -> None:
        """Copy the newest message of every topic into the inbox."""
