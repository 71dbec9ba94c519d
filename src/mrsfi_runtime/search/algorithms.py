"""The search algorithms: the paper's, and two controls on as many evaluations.

An algorithm asks for the fitness of fault specifications and is told it; it neither
evaluates nor records. Asking and telling again from the same seed gives the same, so a
run is repeated, or resumed, by telling it what was recorded.

References
----------
Source paper, section III-E.
"""

import json
import statistics
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from random import Random
from types import MappingProxyType
from typing import Any, Protocol, TypeAlias

from deap import base, tools

from mrsfi_runtime.model.faults import Specification
from mrsfi_runtime.search.individuals import Individual, mate, mutate
from mrsfi_runtime.search.selection import SELECTIONS, Selection, uniform
from mrsfi_runtime.search.settings import CampaignSettings
from mrsfi_runtime.search.space import SearchSpace
from mrsfi_runtime.search.specifications import random_specification


@dataclass(frozen=True, slots=True)
class GenerationSummary:
    """A generation whose fitness is known.

    Attributes
    ----------
    statistics
        ``n_evaluations``: how many specifications were asked for; ``mean``, ``std``,
        ``min`` and ``max`` of the population's fitness.
    population
        For each individual, which of the specifications ever asked for it is, from 0.
        Shape ``(n_individuals,)``.
    """

    index: int
    statistics: Mapping[str, float]
    population: tuple[int, ...]


class Algorithm(Protocol):
    """A search, turn by turn: ``ask``, evaluate, ``tell``, until it is finished."""

    @property
    def is_finished(self) -> bool:
        """Whether there is nothing left to ask."""

    def ask(self) -> list[Specification]:
        """Return the specifications of the next generation that need evaluation."""

    def tell(self, fitness: Sequence[float]) -> GenerationSummary:
        """Take their fitness, in the same order, and end the generation."""

    def random_state(self) -> str:
        """Return the state of the random generator as JSON text."""


Breeding: TypeAlias = Callable[[Sequence[Individual]], list[Individual]]
"""From a population, empty at first, the next one; who is not evaluated yet will be."""


class GenerationalLoop:
    """An algorithm that replaces its whole population in every generation.

    Generation 0 is the first population. The run ends after ``settings.generations``
    more, or, if ``settings.evaluations`` is set, after exactly that many evaluations:
    individuals beyond it are left out of the last generation. It also ends when a
    generation after the last of ``settings.generations`` asks for nothing.
    """

    def __init__(self, settings: CampaignSettings, rng: Random, breed: Breeding) -> None:
        self._settings = settings
        self._rng = rng
        self._breed = breed
        self._population: list[Individual] = []
        self._pending: list[Individual] | None = None
        self._n_asked = 0
        self._n_closed = 0
        self._is_idle = False
        self._statistics = tools.Statistics(lambda individual: individual.fitness.values[0])
        self._statistics.register("mean", statistics.fmean)
        self._statistics.register("std", statistics.pstdev)
        self._statistics.register("min", min)
        self._statistics.register("max", max)

    @property
    def is_finished(self) -> bool:
        """Whether the generations or evaluations are used up."""
        limit = self._settings.evaluations
        if limit is not None and self._n_asked >= limit:
            return self._pending is None
        are_generations_over = self._n_closed > self._settings.generations
        return are_generations_over and (limit is None or self._is_idle)

    def ask(self) -> list[Specification]:
        """Breed the next generation and return its specifications that need evaluation.

        Raises
        ------
        ValueError
            If the fitness of those asked for before was not told, or the run is finished.
        """
        if self._pending is not None or self.is_finished:
            message = "expected the fitness of what was asked for, or a new run; found another ask"
            raise ValueError(message)
        population = []
        pending: list[Individual] = []
        room = self._room()
        for individual in self._breed(self._population):
            if not individual.is_evaluated:
                if room is not None and len(pending) >= room:
                    continue
                individual.number = self._n_asked + len(pending)
                pending.append(individual)
            population.append(individual)
        self._population = population
        self._pending = pending
        self._n_asked += len(pending)
        self._is_idle = not pending
        return [individual.specification for individual in pending]

    def _room(self) -> int | None:
        limit = self._settings.evaluations
        return None if limit is None else limit - self._n_asked

    def tell(self, fitness: Sequence[float]) -> GenerationSummary:
        """Take the fitness of the specifications asked for, in the same order.

        Raises
        ------
        ValueError
            If nothing was asked for, or the number differs.
        EvaluationError
            If a fitness is not a finite number.
        """
        if self._pending is None or len(fitness) != len(self._pending):
            n_expected = 0 if self._pending is None else len(self._pending)
            message = f"found {len(fitness)} fitness values; expected {n_expected} after an ask"
            raise ValueError(message)
        for individual, value in zip(self._pending, fitness, strict=True):
            individual.assess(value)
        n_evaluations = len(self._pending)
        self._pending = None
        self._n_closed += 1
        return GenerationSummary(
            index=self._n_closed - 1,
            statistics={"n_evaluations": n_evaluations}
            | self._statistics.compile(self._population),
            population=tuple(
                individual.number
                for individual in self._population
                if individual.number is not None
            ),
        )

    def random_state(self) -> str:
        """Return the state of the random generator as JSON text."""
        return json.dumps(self._rng.getstate())


def paper(space: SearchSpace, settings: CampaignSettings) -> Algorithm:
    """Return the paper's loop: select, exchange faults in pairs, mutate, replace all.

    References
    ----------
    Source paper, section III-E. An offspring that variation left as its parent was keeps
    the parent's fitness and is not evaluated again.
    """
    return _evolution(space, settings, settings.chosen("selection", SELECTIONS))


def drift(space: SearchSpace, settings: CampaignSettings) -> Algorithm:
    """Return the paper's loop without selection pressure: variation alone, as a control."""
    return _evolution(space, settings, uniform)


def random_search(space: SearchSpace, settings: CampaignSettings) -> Algorithm:
    """Return a control that draws every generation afresh."""
    rng = Random(settings.seed)
    return GenerationalLoop(settings, rng, lambda _: _random_population(space, settings, rng))


def _evolution(space: SearchSpace, settings: CampaignSettings, select: Selection) -> Algorithm:
    rng = Random(settings.seed)
    toolbox = base.Toolbox()
    toolbox.register("population", _random_population, space, settings, rng)
    toolbox.register("select", select, n_selected=settings.population, rng=rng)
    toolbox.register("clone", Individual.clone)
    toolbox.register("mate", mate, space=space, rng=rng)
    toolbox.register("mutate", mutate, space=space, rng=rng, share=settings.mutation_share)
    return GenerationalLoop(
        settings, rng, lambda parents: _offspring(parents, settings, rng, toolbox)
    )


def _random_population(
    space: SearchSpace, settings: CampaignSettings, rng: Random
) -> list[Individual]:
    return [
        Individual(random_specification(space, settings.faults, rng))
        for _ in range(settings.population)
    ]


def _offspring(
    parents: Sequence[Individual], settings: CampaignSettings, rng: Random, toolbox: Any
) -> list[Individual]:
    if not parents:
        first: list[Individual] = toolbox.population()
        return first
    offspring = [toolbox.clone(parent) for parent in toolbox.select(parents)]
    for one, other in zip(offspring[::2], offspring[1::2], strict=False):  # an odd one stays alone
        if rng.random() < settings.crossover:
            toolbox.mate(one, other)
    for individual in offspring:
        if rng.random() < settings.mutation:
            toolbox.mutate(individual)
    return offspring


AlgorithmFactory: TypeAlias = Callable[[SearchSpace, CampaignSettings], Algorithm]

ALGORITHMS: Mapping[str, AlgorithmFactory] = MappingProxyType(
    {"paper": paper, "random": random_search, "drift": drift}
)
"""Algorithms by their name in a campaign file."""
