"""The interface of a search algorithm, and the loop that most of them are.

An algorithm asks for the scores of fault specifications and is told them; it neither
evaluates nor records. Asking and telling again from the same seed gives the same, so a
run is repeated, or resumed, by telling it what was recorded.
"""

import json
import statistics
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from random import Random
from typing import Protocol, Self, TypeAlias

from mrsfi_runtime.model.faults import Specification
from mrsfi_runtime.record.settings import CampaignSettings
from mrsfi_runtime.search.fitness import Score
from mrsfi_runtime.search.individuals import Individual
from mrsfi_runtime.search.space import SearchSpace

MOST_IDLE = 1000
"""Generations in a row without a new specification after which a number of evaluations is given
up: variation makes none any more, as with both chances at 0."""


@dataclass(frozen=True, slots=True)
class GenerationSummary:
    """A generation whose fitness is known.

    ``statistics`` has ``n_evaluations``, how many specifications were asked for, and ``mean``,
    ``std``, ``min`` and ``max`` of the population's fitness. ``population`` says for each
    individual which of the specifications ever asked for it is, from 0.
    """

    index: int
    statistics: Mapping[str, float]
    population: tuple[int, ...]

    @classmethod
    def of(
        cls, index: int, n_evaluations: int, fitness: Sequence[float], population: Iterable[int]
    ) -> Self:
        """Return that of a population with such fitness, of which so many were asked for."""
        found = {
            "n_evaluations": n_evaluations,
            "mean": statistics.fmean(fitness),
            "std": statistics.pstdev(fitness),
            "min": min(fitness),
            "max": max(fitness),
        }
        return cls(index, found, tuple(population))


class Algorithm(Protocol):
    """A search, turn by turn: ``ask``, evaluate, ``tell``, until it is finished."""

    @property
    def is_finished(self) -> bool:
        """Whether there is nothing left to ask."""

    def ask(self) -> list[Specification]:
        """Return the specifications of the next generation that need evaluation."""

    def tell(self, scores: Sequence[Score]) -> GenerationSummary:
        """Take their scores, in the same order, and end the generation."""

    def random_state(self) -> str:
        """Return the state of the random generator as JSON text."""


Breeding: TypeAlias = Callable[[Sequence[Individual]], list[Individual]]
"""From a population, empty at first, its offspring; who is not evaluated yet will be."""

Survival: TypeAlias = Callable[[Sequence[Individual], list[Individual]], list[Individual]]
"""From a population and its evaluated offspring the next population, not empty."""


class GenerationalLoop:
    """An algorithm that breeds offspring, and lets some of them and of the population survive.

    Generation 0 is the first population. The run ends after ``settings.generations``
    more. If ``settings.evaluations`` is set, it ends after exactly that many evaluations
    instead: individuals beyond it are left out of the last generation. Then it ends early only
    after ``MOST_IDLE`` generations in a row that ask for nothing.
    """

    def __init__(
        self, settings: CampaignSettings, rng: Random, breed: Breeding, survive: Survival
    ) -> None:
        self._settings = settings
        self._rng = rng
        self._breed = breed
        self._survive = survive
        self._population: list[Individual] = []
        self._offspring: list[Individual] = []
        self._pending: list[Individual] = []
        self._n_asked = 0
        self._n_closed = 0
        self._n_idle = 0

    @property
    def is_finished(self) -> bool:
        """Whether the generations or evaluations are used up, or nothing new is bred any more."""
        limit = self._settings.evaluations
        if limit is None:
            return self._n_closed > self._settings.generations
        return self._n_asked >= limit or self._n_idle >= MOST_IDLE

    def ask(self) -> list[Specification]:
        """Breed the next generation and return its specifications that need evaluation."""
        self._offspring, self._pending = [], []
        for individual in self._breed(self._population):
            if not individual.is_evaluated:
                if self._n_asked == self._settings.evaluations:
                    continue
                individual.number = self._n_asked
                self._n_asked += 1
                self._pending.append(individual)
            self._offspring.append(individual)
        return [individual.specification for individual in self._pending]

    def tell(self, scores: Sequence[Score]) -> GenerationSummary:
        """Take the scores of the specifications asked for, in the same order."""
        for individual, score in zip(self._pending, scores, strict=True):
            individual.assess(score)
        self._population = self._survive(self._population, self._offspring)
        fitness = [individual.score.fitness for individual in self._population]
        numbers = (individual.number for individual in self._population)
        self._n_closed += 1
        self._n_idle = 0 if self._pending else self._n_idle + 1
        return GenerationSummary.of(
            self._n_closed - 1,
            len(self._pending),
            fitness,
            (number for number in numbers if number is not None),
        )

    def random_state(self) -> str:
        """Return the state of the random generator as JSON text."""
        return json.dumps(self._rng.getstate())


AlgorithmFactory: TypeAlias = Callable[[SearchSpace, CampaignSettings], Algorithm]
"""Begins a search."""
