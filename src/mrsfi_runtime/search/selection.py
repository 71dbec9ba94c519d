"""Which individuals become parents.

DEAP draws from Python's global random generator; here it is lent the search's own state
for the time of a selection.

References
----------
Source paper, section III-E d).
"""

import random
from bisect import bisect_right
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from itertools import accumulate
from operator import attrgetter
from random import Random
from types import MappingProxyType
from typing import TypeAlias

from deap import tools

from mrsfi_runtime.errors import EvaluationError
from mrsfi_runtime.search.individuals import Individual

Selection: TypeAlias = Callable[[Sequence[Individual], int, Random], list[Individual]]
"""Selects individuals, themselves and not copies: clone before varying."""


@contextmanager
def lent_to_deap(rng: Random) -> Iterator[None]:
    """Let Python's global generator continue another one, then give both their own back."""
    kept = random.getstate()
    random.setstate(rng.getstate())
    try:
        yield
    finally:
        rng.setstate(random.getstate())
        random.setstate(kept)


def roulette(individuals: Sequence[Individual], n_selected: int, rng: Random) -> list[Individual]:
    """Select by spins of a roulette whose slots are as wide as the fitness.

    It selects as DEAP's does, which adds up all slots anew at every spin. If all fitness is zero,
    selection is uniform: DEAP's roulette would return nobody.

    Raises
    ------
    EvaluationError
        If a fitness is negative.
    """
    lowest = min(individual.fitness.values[0] for individual in individuals)
    if lowest < 0:
        raise EvaluationError(f"roulette selection found fitness {lowest}; it needs fitness >= 0")
    if not any(individual.fitness.values[0] for individual in individuals):
        return uniform(individuals, n_selected, rng)
    ranked = sorted(individuals, key=attrgetter("fitness"), reverse=True)
    ends = list(accumulate(individual.fitness.values[0] for individual in ranked))
    total = sum(individual.fitness.values[0] for individual in individuals)
    selected: list[Individual] = []
    while len(selected) < n_selected:
        slot = bisect_right(ends, rng.random() * total)
        if slot < len(ranked):  # by rounding, a spin can end behind the last slot
            selected.append(ranked[slot])
    return selected


def uniform(individuals: Sequence[Individual], n_selected: int, rng: Random) -> list[Individual]:
    """Select without regard to fitness."""
    with lent_to_deap(rng):
        return list(tools.selRandom(individuals, n_selected))


def tournament(individuals: Sequence[Individual], n_selected: int, rng: Random) -> list[Individual]:
    """Select the best of three drawn at random, again and again."""
    with lent_to_deap(rng):
        return list(tools.selTournament(individuals, n_selected, tournsize=3))


def best(individuals: Sequence[Individual], n_selected: int, rng: Random) -> list[Individual]:  # noqa: ARG001 - Selection
    """Select the best, each once."""
    return list(tools.selBest(individuals, n_selected))


SELECTIONS: Mapping[str, Selection] = MappingProxyType(
    {"roulette": roulette, "tournament": tournament, "best": best, "uniform": uniform}
)
"""Selections by their name in a campaign file."""
