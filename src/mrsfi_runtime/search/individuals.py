"""Individuals as DEAP sees them, and which of them become parents.

Individuals are lists of immutable timed faults with a fitness. The classes are plain ones:
``deap.creator`` would keep them in a global registry. DEAP draws from Python's global random
generator; here it is lent the search's own state for the time of a selection.

References
----------
Source paper, sections III-E a) and d).
"""

import random
from bisect import bisect_right
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from itertools import accumulate
from operator import attrgetter
from random import Random
from types import MappingProxyType
from typing import Self, TypeAlias

from deap import base, tools

from mrsfi_runtime.errors import EvaluationError
from mrsfi_runtime.model.faults import Specification, TimedFault
from mrsfi_runtime.search.fitness import Score


class Criticality(base.Fitness):  # type: ignore[misc]  # DEAP has no types
    """How critical a fault specification is: numbers of which more is, then ``costs``, less."""

    def __init__(self, values: Sequence[float] = (), costs: Sequence[int] = ()) -> None:
        self.weights = (1.0,) * len(values) + (-1.0,) * len(costs)
        super().__init__((*values, *costs))


class Individual(list[TimedFault]):
    """A fault specification in evolution, in the order of ``SearchSpace.ordered``.

    DEAP compares ``fitness``, which has no value until the individual is evaluated; ``score`` is
    what it was told last. ``number`` says which of the specifications that the algorithm asked
    for it is, from 0; ``None`` before.
    """

    def __init__(self, specification: Specification) -> None:
        super().__init__(specification)
        self.fitness: base.Fitness = Criticality()
        self.score = Score(0.0, ())
        self.number: int | None = None

    @property
    def specification(self) -> Specification:
        """The timed faults as an immutable value."""
        return tuple(self)

    @property
    def is_evaluated(self) -> bool:
        """Whether the fitness is known."""
        return bool(self.fitness.valid)

    def assess(self, score: Score) -> None:
        """Take the score."""
        self.score = score
        self.fitness = Criticality((score.fitness,))

    def become(self, specification: Specification) -> None:
        """Take the timed faults of another; the fitness is lost if they differ."""
        if specification != self.specification:
            self[:] = specification
            del self.fitness.values
            self.number = None

    def clone(self) -> Self:
        """Return a copy that shares the immutable timed faults."""
        copy = type(self)(self.specification)
        if self.is_evaluated:
            copy.assess(self.score)
        copy.number = self.number
        return copy


def foremost(
    individuals: Sequence[Individual],
    n_selected: int,
    objectives: Callable[[Individual], Criticality],
) -> list[Individual]:
    """Return the first by rank and crowding distance, both entered in their fitness."""
    for individual in individuals:
        individual.fitness = objectives(individual)  # what DEAP compares them by
    n_objectives = len(individuals[0].fitness.weights)
    sorting = "log" if n_objectives > 1 else "standard"  # DEAP's log sort needs two objectives
    return list(tools.selNSGA2(individuals, n_selected, nd=sorting))


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

    It selects as DEAP's does, which adds up all slots anew at every spin; but ``sum`` rounds
    floats otherwise since Python 3.12, so they are added up one after the other. If all fitness
    is zero, selection is uniform: DEAP's roulette would return nobody.
    """
    lowest = min(individual.fitness.values[0] for individual in individuals)
    if lowest < 0:
        raise EvaluationError(f"roulette selection found fitness {lowest}; it needs fitness >= 0")
    if not any(individual.fitness.values[0] for individual in individuals):
        return uniform(individuals, n_selected, rng)
    ranked = sorted(individuals, key=attrgetter("fitness"), reverse=True)
    ends = list(accumulate(individual.fitness.values[0] for individual in ranked))
    *_, total = accumulate(individual.fitness.values[0] for individual in individuals)
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
