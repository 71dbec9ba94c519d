"""The weather of a mission seed: how many samples of every sensor are valid, tick by tick.

It hangs on nothing that happens in a flight, so it is drawn once for all flights of a seed.
"""

from functools import lru_cache
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from mrsfi_runtime.kernel.randomness import PURPOSE_SAMPLES, draw
from mrsfi_runtime.kernel.state import State

CHANCE_PRECISION = 2**32

Weather: TypeAlias = npt.NDArray[np.uint8]
"""Valid samples, shape ``(n_ticks, n_sensors)``: what ``kernel.motion.move`` adds, a row a tick."""


def sample_chances(n: int) -> tuple[int, ...]:
    """Return the cumulative chances of 0, 1, 2 … valid samples, in units of 2**-32.

    Each of ``n`` samples of a tick is valid with chance ``1 / n``, so their number is
    binomial; one draw against these bounds replaces ``n`` draws. The list ends where the
    rest is below the precision of a draw.
    """
    if n == 1:
        return (0,)
    bounds: list[int] = []
    chance = (1.0 - 1.0 / n) ** n
    total = 0.0
    for k in range(n):
        total += chance
        bound = round(total * CHANCE_PRECISION)
        if bound >= CHANCE_PRECISION:
            break
        bounds.append(bound)
        chance *= (n - k) / ((k + 1) * (n - 1))
    return tuple(bounds)


def weather(state: State) -> Weather:
    """Return the weather of a mission and seed, to be read only.

    Parameters
    ----------
    state
        A state before its first tick.
    """
    bounds = tuple(
        state.chances[sensor.first_chance : sensor.first_chance + sensor.n_chances]
        for sensor in state.sensors
    )
    return _drawn(state.mission.seed, state.mission.duration, bounds)


@lru_cache(maxsize=8)
def _drawn(seed: int, duration: int, bounds: tuple[tuple[int, ...], ...]) -> Weather:
    """Return how many of its sensor's bounds each draw reaches."""
    ticks: Any = np.arange(duration, dtype=np.uint64)  # draws all of them at once
    found = np.empty((duration, len(bounds)), np.uint8)
    for sensor, reached in enumerate(bounds):
        draws = draw(seed, ticks, sensor, PURPOSE_SAMPLES)
        found[:, sensor] = np.searchsorted(np.array(reached, np.uint64), draws, side="right")
    found.flags.writeable = False
    return found
