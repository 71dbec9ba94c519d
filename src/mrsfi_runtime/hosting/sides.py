"""What the hosts expect of generated code: a simulation and an interface."""

from collections.abc import Callable
from typing import Protocol

from mrsfi_runtime.kernel.state import State
from mrsfi_runtime.model.mission import Mission
from mrsfi_runtime.transport.topics import Transport


class Simulation(Protocol):
    """A generated simulation: moves the true state and publishes it."""

    world: State

    def __init__(self, transport: Transport, mission: Mission) -> None: ...

    def reset(self, seed: int) -> None:
        """Go back to before the first tick."""

    def step(self, tick: int) -> None:
        """Fly one tick and publish the result."""

    def publish_truth(self) -> None:
        """Publish the true state, for the judge alone."""

    def stop(self) -> None:
        """End the run."""


class SimInterface(Protocol):
    """A generated simulation interface: one getter per robot property, one setter per command."""

    @property
    def set_heading(self) -> tuple[Callable[[float, float], None], ...]:
        """Heading commands by index of the robot."""

    @property
    def set_speed(self) -> tuple[Callable[[float], None], ...]:
        """Speed commands by index of the robot."""

    @property
    def set_active(self) -> tuple[Callable[[bool], None], ...]:
        """Activation commands by index of the sensor."""

    def __init__(self, transport: Transport) -> None: ...

    def reset(self) -> None:
        """Forget what was received."""

    def read(self, inbox: State) -> None:
        """Copy the newest message of every topic into the inbox."""
