"""The true state that a generated simulation moves, and the valid samples of each tick."""

from dataclasses import dataclass

from mrsfi_runtime.kernel import commands, flight
from mrsfi_runtime.kernel.flight import Samples, valid_samples
from mrsfi_runtime.kernel.state import State
from mrsfi_runtime.model.mission import Mission


@dataclass(slots=True)
class World(State):
    """A true state; ``samples[tick]`` has the valid samples of each sensor."""

    samples: Samples


def initial_state(mission: Mission, seed: int) -> World:
    """Return what is true before the first tick; as ``kernel.initial.initial_state``."""
    state = flight.initial_state(mission, seed)
    known = {name: getattr(state, name) for name in State.__slots__}
    return World(**known, samples=valid_samples(state))


def move(world: World, tick: int) -> None:
    """Fly a tick, as ``kernel.motion.move``."""
    commands.move(world, world.samples[tick], tick)
