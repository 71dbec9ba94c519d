"""The search algorithms: the paper's, DEAP's, one of our own, and two controls.

DEAP's own loops evaluate and record by themselves; here one of their turns at a time is
asked for and told. Variation is ``varAnd`` and ``varOr``, and operators are those that the
campaign file names.

References
----------
Source paper, section III-E.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import cycle, islice
from random import Random
from types import MappingProxyType
from typing import Any

from deap import algorithms, base, tools

from mrsfi_runtime.errors import UsageError
from mrsfi_runtime.model.faults import Specification
from mrsfi_runtime.record.settings import CampaignSettings
from mrsfi_runtime.search.eda import FaultModel
from mrsfi_runtime.search.fitness import Score
from mrsfi_runtime.search.guided import guided
from mrsfi_runtime.search.individuals import (
    SELECTIONS,
    Criticality,
    Individual,
    foremost,
    lent_to_deap,
    uniform,
)
from mrsfi_runtime.search.loop import (
    Algorithm,
    AlgorithmFactory,
    Breeding,
    GenerationalLoop,
    GenerationSummary,
    Survival,
)
from mrsfi_runtime.search.space import SearchSpace
from mrsfi_runtime.search.specifications import first_size, random_specification
from mrsfi_runtime.search.steps import MUTATIONS, resized
from mrsfi_runtime.search.user_functions import chosen, told_by_line
from mrsfi_runtime.search.variation import CROSSOVERS


class Breeder:
    """Draws, varies and selects individuals as the settings of a campaign say, all by ``rng``."""

    def __init__(self, space: SearchSpace, settings: CampaignSettings) -> None:
        self.rng = Random(settings.seed)
        self.size = settings.population
        self._space = space
        self._settings = settings
        self._select = chosen(settings, "selection", SELECTIONS)
        self._crossover = chosen(settings, "crossover_operator", CROSSOVERS)
        self._mutation = chosen(settings, "mutation_operator", MUTATIONS)
        if settings.minimise:
            self._mutation = partial(resized, mutation=self._mutation, n_most=settings.faults)

    def first(self) -> list[Individual]:
        """Draw a population."""
        sizes = (first_size(self._settings, self.rng) for _ in range(self.size))
        return [Individual(random_specification(self._space, n, self.rng)) for n in sizes]

    def select(self, individuals: Sequence[Individual]) -> list[Individual]:
        """Select as many as a population has; themselves, not copies."""
        return self._select(individuals, self.size, self.rng)

    def toolbox(self, rng: Random) -> Any:
        """Return the operators as DEAP's algorithms take them, drawing from a generator."""
        space, share = self._space, self._settings.mutation_share

        def mate(first: Individual, second: Individual) -> tuple[Individual, Individual]:
            one, other = self._crossover(space, first.specification, second.specification, rng)
            first.become(one)
            second.become(other)
            return first, second

        def mutate(individual: Individual) -> tuple[Individual]:
            individual.become(self._mutation(space, individual.specification, rng, share))
            return (individual,)

        toolbox = base.Toolbox()
        toolbox.register("clone", Individual.clone)
        toolbox.register("mate", mate)
        toolbox.register("mutate", mutate)
        return toolbox

    def varied(self, selected: Sequence[Individual]) -> list[Individual]:
        """Vary by crossover and mutation, as the paper does."""
        rng, toolbox = self.rng, self.toolbox(self.rng)
        offspring = [individual.clone() for individual in selected]
        for pair in zip(offspring[::2], offspring[1::2], strict=False):  # an odd one stays alone
            if rng.random() < self._settings.crossover:
                toolbox.mate(*pair)
        for individual in offspring:
            if rng.random() < self._settings.mutation:
                toolbox.mutate(individual)
        return offspring

    def vary_and(self, selected: Sequence[Individual]) -> list[Individual]:
        """Vary by crossover and mutation, as DEAP does."""
        chances = self._settings.crossover, self._settings.mutation
        return self._by_deap(algorithms.varAnd, selected, *chances)

    def vary_or(self, parents: Sequence[Individual], n_offspring: int) -> list[Individual]:
        """Vary by crossover or mutation; their chances share what is above 1 in proportion."""
        crossover = self._settings.crossover if len(parents) > 1 else 0.0
        total = max(1.0, crossover + self._settings.mutation)
        share = crossover / total
        mutation = min(self._settings.mutation / total, 1.0 - share)
        return self._by_deap(algorithms.varOr, parents, n_offspring, share, mutation)

    def _by_deap(
        self, vary: Any, individuals: Sequence[Individual], *numbers: float
    ) -> list[Individual]:
        """Let DEAP draw from the search's generator; the operators need another then."""
        toolbox = self.toolbox(Random(self.rng.getrandbits(64)))
        with lent_to_deap(self.rng):
            return list(vary(individuals, toolbox, *numbers))

    def loop(
        self, breed: Breeding, survive: Survival = lambda _, offspring: offspring
    ) -> Algorithm:
        """Return the algorithm that breeds from every population but the first."""
        return GenerationalLoop(
            self._settings,
            self.rng,
            lambda parents: breed(parents) if parents else self.first(),
            survive,
        )


def ea_simple(space: SearchSpace, settings: CampaignSettings) -> Algorithm:
    """Return DEAP's ``eaSimple``: select, vary by crossover and mutation, replace all.

    It differs from ``paper`` in that whoever crossover or mutation touched is evaluated, also if
    it came out as it was.
    """
    breeder = Breeder(space, settings)
    return breeder.loop(lambda parents: breeder.vary_and(breeder.select(parents)))


def ea_mu_plus_lambda(space: SearchSpace, settings: CampaignSettings) -> Algorithm:
    """Return DEAP's ``eaMuPlusLambda``: parents and offspring compete for the next generation."""
    breeder = Breeder(space, settings)
    n_offspring = settings.offspring or settings.population
    return breeder.loop(
        lambda parents: breeder.vary_or(parents, n_offspring),
        lambda parents, offspring: breeder.select([*parents, *offspring]) if parents else offspring,
    )


def ea_mu_comma_lambda(space: SearchSpace, settings: CampaignSettings) -> Algorithm:
    """Return DEAP's ``eaMuCommaLambda``: only the offspring compete."""
    n_offspring = settings.offspring or 2 * settings.population
    if n_offspring < settings.population:
        raise UsageError(
            f"{settings.where('offspring')}: found {n_offspring}; eaMuCommaLambda needs "
            f"at least as many as population, {settings.population}"
        )
    breeder = Breeder(space, settings)
    return breeder.loop(
        lambda parents: breeder.vary_or(parents, n_offspring),
        lambda parents, offspring: breeder.select(offspring) if parents else offspring,
    )


def ea_generate_update(space: SearchSpace, settings: CampaignSettings) -> Algorithm:
    """Return DEAP's ``eaGenerateUpdate`` on a model of fault windows and values."""
    rng = Random(settings.seed)
    model = FaultModel(space, settings.faults, rng)

    def survive(_: Sequence[Individual], offspring: list[Individual]) -> list[Individual]:
        model.update(offspring)
        return offspring

    return GenerationalLoop(
        settings,
        rng,
        lambda _: [Individual(model.generate()) for _ in range(settings.population)],
        survive,
    )


def nsga2(space: SearchSpace, settings: CampaignSettings) -> Algorithm:
    """Return NSGA-II on the goal vector, and on what the settings want to be minimised.

    The fitness function plays no part in it.

    References
    ----------
    Deb et al., *A fast and elitist multiobjective genetic algorithm: NSGA-II*, 2002.
    """
    breeder = Breeder(space, settings)

    def objectives(individual: Individual) -> Criticality:
        costs = settings.costs(individual.specification, space.duration)
        return Criticality(individual.score.goals, costs)

    def breed(parents: Sequence[Individual]) -> list[Individual]:
        n_padding = -len(parents) % 4  # the tournament takes four at a time
        padded = [*parents, *islice(cycle(parents), n_padding)]
        with lent_to_deap(breeder.rng):
            selected = tools.selTournamentDCD(padded, len(padded))
        return breeder.vary_and(selected[: breeder.size])

    return breeder.loop(
        breed,
        lambda parents, offspring: foremost([*parents, *offspring], breeder.size, objectives),
    )


def paper(space: SearchSpace, settings: CampaignSettings) -> Algorithm:
    """Return the paper's loop: select, exchange faults in pairs, mutate, replace all.

    References
    ----------
    Source paper, section III-E. An offspring that variation left as its parent was keeps
    the parent's fitness and is not evaluated again.
    """
    breeder = Breeder(space, settings)
    return breeder.loop(lambda parents: breeder.varied(breeder.select(parents)))


def drift(space: SearchSpace, settings: CampaignSettings) -> Algorithm:
    """Return the paper's loop without selection pressure: variation alone, as a control."""
    breeder = Breeder(space, settings)
    return breeder.loop(lambda parents: breeder.varied(uniform(parents, breeder.size, breeder.rng)))


def random_search(space: SearchSpace, settings: CampaignSettings) -> Algorithm:
    """Return a control that draws every generation afresh."""
    breeder = Breeder(space, settings)
    return breeder.loop(lambda _: breeder.first())


ALGORITHMS: Mapping[str, AlgorithmFactory] = MappingProxyType(
    {
        "paper": paper,
        "eaSimple": ea_simple,
        "eaMuPlusLambda": ea_mu_plus_lambda,
        "eaMuCommaLambda": ea_mu_comma_lambda,
        "eaGenerateUpdate": ea_generate_update,
        "nsga2": nsga2,
        "guided": guided,
        "random": random_search,
        "drift": drift,
    }
)
"""Algorithms that vary and select, by their name in a campaign file."""


_MADE_BY_TEAMS = ("algorithm", "selection", "crossover_operator", "mutation_operator")


def begin_search(
    space: SearchSpace,
    settings: CampaignSettings,
    algorithms: Mapping[str, AlgorithmFactory] = ALGORITHMS,
) -> Algorithm:
    """Begin the search that settings name; check what it makes if a team wrote a part of it."""
    algorithm = chosen(settings, "algorithm", algorithms)(space, settings)
    named = {key: getattr(settings, key) for key in _MADE_BY_TEAMS}
    written = [f"{settings.where(key)} {name!r}" for key, name in named.items() if ":" in name]
    return _UserAlgorithm(algorithm, space, " or ".join(written)) if written else algorithm


@dataclass(frozen=True, slots=True)
class _UserAlgorithm:
    algorithm: Algorithm
    space: SearchSpace
    where: str

    @property
    def is_finished(self) -> bool:
        with told_by_line(self.where):
            return self.algorithm.is_finished

    def ask(self) -> list[Specification]:
        with told_by_line(self.where):
            asked = self.algorithm.ask()
            return [self.space.require(specification, self.where) for specification in asked]

    def tell(self, scores: Sequence[Score]) -> GenerationSummary:
        with told_by_line(self.where):
            summary = self.algorithm.tell(scores)
        if not isinstance(summary, GenerationSummary):
            found = type(summary).__name__
            raise UsageError(f"{self.where}: tell returned {found}; expected a GenerationSummary")
        return summary

    def random_state(self) -> str:
        with told_by_line(self.where):
            return self.algorithm.random_state()
