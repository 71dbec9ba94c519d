"""DEAP's algorithms behind the interface of a search, with the paper's individuals.

DEAP's own loops evaluate and record by themselves; here one of their turns at a time is
asked for and told. Variation is ``varAnd`` and ``varOr``, and operators are those that the
campaign file names.
"""

from collections.abc import Sequence
from itertools import cycle, islice
from random import Random
from typing import Any

from deap import algorithms, base, tools

from mrsfi_runtime.errors import UsageError
from mrsfi_runtime.record.settings import CampaignSettings
from mrsfi_runtime.search.estimation import FaultModel
from mrsfi_runtime.search.individuals import GoalIndividual, Individual, mate, mutate
from mrsfi_runtime.search.loop import Algorithm, Breeding, GenerationalLoop, Survival, replaced
from mrsfi_runtime.search.selection import SELECTIONS, lent_to_deap
from mrsfi_runtime.search.space import SearchSpace
from mrsfi_runtime.search.specifications import random_specification
from mrsfi_runtime.search.steps import MUTATIONS
from mrsfi_runtime.search.user_functions import chosen
from mrsfi_runtime.search.variation import CROSSOVERS


def ea_simple(space: SearchSpace, settings: CampaignSettings) -> Algorithm:
    """Return DEAP's ``eaSimple``: select, vary by crossover and mutation, replace all.

    Notes
    -----
    It differs from ``paper`` in that whoever crossover or mutation touched is evaluated, also
    if it came out as it was.
    """
    return _Breeder(space, settings).simple()


def ea_mu_plus_lambda(space: SearchSpace, settings: CampaignSettings) -> Algorithm:
    """Return DEAP's ``eaMuPlusLambda``: parents and offspring compete for the next generation."""
    return _Breeder(space, settings).mu_lambda(settings.offspring or settings.population, plus=True)


def ea_mu_comma_lambda(space: SearchSpace, settings: CampaignSettings) -> Algorithm:
    """Return DEAP's ``eaMuCommaLambda``: only the offspring compete.

    Raises
    ------
    UsageError
        If there are fewer offspring than individuals in a population.
    """
    n_offspring = settings.offspring or 2 * settings.population
    if n_offspring < settings.population:
        message = (
            f"{settings.source}: [search] offspring: found {n_offspring}; eaMuCommaLambda needs "
            f"at least as many as population, {settings.population}"
        )
        raise UsageError(message)
    return _Breeder(space, settings).mu_lambda(n_offspring, plus=False)


def ea_generate_update(space: SearchSpace, settings: CampaignSettings) -> Algorithm:
    """Return DEAP's ``eaGenerateUpdate`` on a model of fault windows and values."""
    rng = Random(settings.seed)
    model = FaultModel(space, settings.faults, rng)
    toolbox = base.Toolbox()
    toolbox.register("generate", model.generate)
    toolbox.register("update", model.update)

    def survive(_: Sequence[Individual], offspring: list[Individual]) -> list[Individual]:
        toolbox.update(offspring)
        return offspring

    return GenerationalLoop(
        settings,
        rng,
        lambda _: [Individual(toolbox.generate()) for _ in range(settings.population)],
        survive,
    )


def nsga2(space: SearchSpace, settings: CampaignSettings) -> Algorithm:
    """Return NSGA-II on the goal vector; the fitness function plays no part in it.

    References
    ----------
    Deb et al., *A fast and elitist multiobjective genetic algorithm: NSGA-II*, 2002.
    """
    return _Breeder(space, settings, GoalIndividual).nsga2()


class _Breeder:
    """What DEAP's algorithms have in common: first population, operators, random numbers."""

    def __init__(
        self,
        space: SearchSpace,
        settings: CampaignSettings,
        kind: type[Individual] = Individual,
    ) -> None:
        self._space = space
        self._settings = settings
        self._kind = kind
        self._rng = Random(settings.seed)
        self._select = chosen(settings, "selection", SELECTIONS)
        self._cross = chosen(settings, "crossover_operator", CROSSOVERS)
        self._mutate = chosen(settings, "mutation_operator", MUTATIONS)

    def simple(self) -> Algorithm:
        size = self._settings.population
        return self._loop(
            lambda parents: self._vary_and(self._select(parents, size, self._rng)),
            replaced,
        )

    def mu_lambda(self, n_offspring: int, *, plus: bool) -> Algorithm:
        size = self._settings.population

        def survive(parents: Sequence[Individual], offspring: list[Individual]) -> list[Individual]:
            pool = [*parents, *offspring] if plus else offspring
            return self._select(pool, size, self._rng) if parents else offspring

        return self._loop(lambda parents: self._vary_or(parents, n_offspring), survive)

    def nsga2(self) -> Algorithm:
        size = self._settings.population

        def breed(parents: Sequence[Individual]) -> list[Individual]:
            n_padding = -len(parents) % 4  # the tournament takes four at a time
            padded = [*parents, *islice(cycle(parents), n_padding)]
            with lent_to_deap(self._rng):
                selected = tools.selTournamentDCD(padded, len(padded))
            return self._vary_and(selected[:size])

        def survive(parents: Sequence[Individual], offspring: list[Individual]) -> list[Individual]:
            return _fittest_by_goals([*parents, *offspring], size)

        return self._loop(breed, survive)

    def _loop(self, breed: Breeding, survive: Survival) -> Algorithm:
        return GenerationalLoop(
            self._settings,
            self._rng,
            lambda parents: breed(parents) if parents else self._first(),
            survive,
        )

    def _first(self) -> list[Individual]:
        return [
            self._kind(random_specification(self._space, self._settings.faults, self._rng))
            for _ in range(self._settings.population)
        ]

    def _toolbox(self) -> Any:
        """Return the operators; DEAP draws from the search's generator, so they need another."""
        rng = Random(self._rng.getrandbits(64))
        settings, space = self._settings, self._space
        toolbox = base.Toolbox()
        toolbox.register("clone", Individual.clone)
        toolbox.register("mate", mate, space=space, rng=rng, operator=self._cross)
        toolbox.register(
            "mutate",
            mutate,
            space=space,
            rng=rng,
            share=settings.mutation_share,
            operator=self._mutate,
        )
        return toolbox

    def _vary_and(self, selected: Sequence[Individual]) -> list[Individual]:
        toolbox = self._toolbox()
        with lent_to_deap(self._rng):
            return list(
                algorithms.varAnd(
                    selected, toolbox, self._settings.crossover, self._settings.mutation
                )
            )

    def _vary_or(self, parents: Sequence[Individual], n_offspring: int) -> list[Individual]:
        """Vary by crossover or mutation; their chances share what is above 1 in proportion."""
        toolbox = self._toolbox()
        crossover = self._settings.crossover if len(parents) > 1 else 0.0
        mutation = self._settings.mutation
        total = max(1.0, crossover + mutation)
        share = crossover / total
        with lent_to_deap(self._rng):
            return list(
                algorithms.varOr(
                    parents, toolbox, n_offspring, share, min(mutation / total, 1.0 - share)
                )
            )


def _fittest_by_goals(individuals: list[Individual], n_selected: int) -> list[Individual]:
    """Return the first by rank and crowding distance, both entered in their fitness."""
    n_goals = len(individuals[0].score.goals)
    sorting = "log" if n_goals > 1 else "standard"  # DEAP's log sort needs two objectives
    return list(tools.selNSGA2(individuals, n_selected, nd=sorting))
