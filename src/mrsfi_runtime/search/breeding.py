"""What the evolutionary algorithms have in common: first population, operators, random numbers."""

from collections.abc import Sequence
from functools import partial
from random import Random
from typing import Any

from deap import base

from mrsfi_runtime.record.settings import CampaignSettings
from mrsfi_runtime.search.individuals import Individual, mate, mutate
from mrsfi_runtime.search.loop import Algorithm, Breeding, GenerationalLoop, Survival, replaced
from mrsfi_runtime.search.selection import SELECTIONS
from mrsfi_runtime.search.space import SearchSpace
from mrsfi_runtime.search.specifications import random_specification
from mrsfi_runtime.search.steps import MUTATIONS
from mrsfi_runtime.search.user_functions import chosen
from mrsfi_runtime.search.variation import CROSSOVERS


class Breeder:
    """Draws, varies and selects individuals as the settings of a campaign say.

    Parameters
    ----------
    kind
        What DEAP compares individuals by.

    Attributes
    ----------
    rng
        The random generator of the search; all draws come from it.
    size
        Individuals of a population.
    """

    def __init__(
        self, space: SearchSpace, settings: CampaignSettings, kind: type[Individual] = Individual
    ) -> None:
        self.rng = Random(settings.seed)
        self.size = settings.population
        self._space = space
        self._settings = settings
        self._kind = kind
        self._select = chosen(settings, "selection", SELECTIONS)
        self._crossover = chosen(settings, "crossover_operator", CROSSOVERS)
        self._mutation = chosen(settings, "mutation_operator", MUTATIONS)

    def first(self) -> list[Individual]:
        """Draw a population."""
        return [
            self._kind(random_specification(self._space, self._settings.faults, self.rng))
            for _ in range(self.size)
        ]

    def select(self, individuals: Sequence[Individual]) -> list[Individual]:
        """Select as many as a population has; themselves, not copies."""
        return self._select(individuals, self.size, self.rng)

    def toolbox(self, rng: Random) -> Any:
        """Return the operators as DEAP's algorithms take them, drawing from a generator."""
        space, share = self._space, self._settings.mutation_share
        varied = partial(mutate, space=space, rng=rng, share=share, operator=self._mutation)
        toolbox = base.Toolbox()
        toolbox.register("clone", Individual.clone)
        toolbox.register("mate", mate, space=space, rng=rng, operator=self._crossover)
        toolbox.register("mutate", varied)
        return toolbox

    def loop(self, breed: Breeding, survive: Survival = replaced) -> Algorithm:
        """Return the algorithm that breeds from every population but the first."""
        return GenerationalLoop(
            self._settings,
            self.rng,
            lambda parents: breed(parents) if parents else self.first(),
            survive,
        )
