"""What a mission seed decides: how many samples of every sensor are valid, tick by tick.

It hangs on nothing that happens in a flight, so it is drawn once for all flights of a seed.
"""

from bisect import bisect_right
from collections.abc import Iterator
from functools import lru_cache
from typing import TypeAlias

from mrsfi_runtime.kernel.randomness import PURPOSE_SAMPLES, draw
from mrsfi_runtime.kernel.state import State

CHANCE_PRECISION = 2**32

Samples: TypeAlias = tuple[bytes, ...]
"""Valid samples of each sensor, a row a tick, each below 256; ``kernel.motion.move`` adds them."""


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


def reached(state: State) -> Iterator[tuple[int, ...]]:
    """Yield the chances of each sensor: of its samples, as many are valid as a draw reaches."""
    for sensor in state.sensors:
        yield state.chances[sensor.first_chance : sensor.first_chance + sensor.n_chances]


def valid_samples(state: State) -> Samples:
    """Return the valid samples of a mission and seed, from a state before its first tick.

    It needs no numpy, whose import takes longer; ``engine.compiled.layout.sample_table`` draws
    the same for many robots at once.
    """
    return _drawn(state.mission.seed, state.mission.duration, tuple(reached(state)))


@lru_cache(maxsize=8)
def _drawn(seed: int, duration: int, chances: tuple[tuple[int, ...], ...]) -> Samples:
    return tuple(
        bytes(
            bisect_right(bounds, draw(seed, tick, sensor, PURPOSE_SAMPLES))
            for sensor, bounds in enumerate(chances)
        )
        for tick in range(duration)
    )
