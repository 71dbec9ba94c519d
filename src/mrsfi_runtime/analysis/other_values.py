"""Which values within its bounds a fault could have instead of the pool's."""

from collections.abc import Iterable, Iterator, Sequence
from itertools import chain, product
from typing import TypeAlias

from mrsfi_runtime.model.bounds import value_bounds
from mrsfi_runtime.model.faults import Fault
from mrsfi_runtime.model.mission import Mission
from mrsfi_runtime.search.space import landmarks

N_STEPS = 32
"""Equal parts into which the bounds of a number are divided, and the paths of robots."""

N_PLACES = 16
"""Equal parts into which the bounds of each coordinate of a place are divided."""

Bounds: TypeAlias = tuple[float, float]
"""Lowest and highest value."""


def other_values(
    mission: Mission, fault: Fault, paths: Iterable[tuple[float, float]] = ()
) -> tuple[tuple[float, ...], ...]:
    """Return values that a fault could have, those nearest to the pool's first.

    Of numbers, one is another and the rest are the pool's: the ends of its bounds and equal steps
    between, rounded where only whole numbers make sense. Of places, the crossings of a grid
    between the bounds, the landmarks of search, and some on the paths of robots, all at the pool's
    height.

    Parameters
    ----------
    mission, fault
        The mission, and a fault of its pool.
    paths
        Places where robots come by, as x and y.

    Returns
    -------
    tuple of tuple of float
        Shape ``(n, n_parameters)``, each once, without the pool's own. Near is measured in shares
        of the bounds' widths, the largest of the parameters'.
    """
    bounds = value_bounds(mission, fault)
    found = _places(bounds, fault, paths) if fault.kind.is_place else _numbers(bounds, fault)
    others = dict.fromkeys((*landmarks(mission, fault), *found))
    others.pop(fault.values, None)

    def steps(values: tuple[float, ...]) -> float:
        return max(
            abs(value - own) / (high - low) if high > low else 0.0
            for value, own, (low, high) in zip(values, fault.values, bounds, strict=True)
        )

    return tuple(sorted(others, key=steps))


def _numbers(bounds: Sequence[Bounds], fault: Fault) -> Iterator[tuple[float, ...]]:
    for place, (parameter, (low, high)) in enumerate(
        zip(fault.kind.parameters, bounds, strict=True)
    ):
        for value in _steps(low, high, N_STEPS):
            own = float(round(value)) if parameter.is_integer else value
            yield (*fault.values[:place], own, *fault.values[place + 1 :])


def _places(
    bounds: Sequence[Bounds], fault: Fault, paths: Iterable[tuple[float, float]]
) -> Iterator[tuple[float, ...]]:
    (left, right), (bottom, top) = bounds[:2]
    grid = product(_steps(left, right, N_PLACES), _steps(bottom, top, N_PLACES))
    for x, y in chain(grid, ((_short(x), _short(y)) for x, y in paths)):
        if left <= x <= right and bottom <= y <= top:
            yield (x, y, *fault.values[2:])


def _steps(low: float, high: float, n: int) -> list[float]:
    return [low, *(_short(low + (high - low) * step / n) for step in range(1, n)), high]


def _short(value: float) -> float:
    """Return a number that can be written down and flown again."""
    return float(f"{value:.5g}")
