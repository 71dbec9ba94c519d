"""The true state that a generated simulation moves, and the weather that it meets."""

from dataclasses import dataclass

from mrsfi_runtime.kernel import initial, motion
from mrsfi_runtime.kernel.state import State
from mrsfi_runtime.kernel.weather import Weather, weather
from mrsfi_runtime.model.mission import Mission


@dataclass(slots=True)
class World(State):
    """A true state; ``weather[tick]`` has the valid samples of each sensor."""

    weather: Weather


def initial_state(mission: Mission, seed: int) -> World:
    """Return what is true before the first tick; as ``kernel.initial.initial_state``."""
    state = initial.initial_state(mission, seed)
    known = {name: getattr(state, name) for name in State.__slots__}
    return World(**known, weather=weather(state))


def move(world: World, tick: int) -> None:
    """Fly a tick, as ``kernel.motion.move``."""
    motion.move(world, world.weather[tick], tick)
