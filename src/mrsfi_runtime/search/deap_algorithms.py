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
from mrsfi_runtime.search.breeding import Breeder
from mrsfi_runtime.search.estimation import FaultModel
from mrsfi_runtime.search.individuals import GoalIndividual, Individual
from mrsfi_runtime.search.loop import Algorithm, GenerationalLoop
from mrsfi_runtime.search.selection import lent_to_deap
from mrsfi_runtime.search.space import SearchSpace


def ea_simple(space: SearchSpace, settings: CampaignSettings) -> Algorithm:
    """Return DEAP's ``eaSimple``: select, vary by crossover and mutation, replace all.

    Notes
    -----
    It differs from ``paper`` in that whoever crossover or mutation touched is evaluated, also
    if it came out as it was.
    """
    breeder = Breeder(space, settings)
    return breeder.loop(lambda parents: _vary_and(breeder, settings, breeder.select(parents)))


def ea_mu_plus_lambda(space: SearchSpace, settings: CampaignSettings) -> Algorithm:
    """Return DEAP's ``eaMuPlusLambda``: parents and offspring compete for the next generation."""
    breeder = Breeder(space, settings)
    n_offspring = settings.offspring or settings.population
    return breeder.loop(
        lambda parents: _vary_or(breeder, settings, parents, n_offspring),
        lambda parents, offspring: breeder.select([*parents, *offspring]) if parents else offspring,
    )


def ea_mu_comma_lambda(space: SearchSpace, settings: CampaignSettings) -> Algorithm:
    """Return DEAP's ``eaMuCommaLambda``: only the offspring compete.

    Raises
    ------
    UsageError
        If there are fewer offspring than individuals in a population.
    """
    n_offspring = settings.offspring or 2 * settings.population
    if n_offspring < settings.population:
        raise UsageError(
            f"{settings.source}: [search] offspring: found {n_offspring}; eaMuCommaLambda needs "
            f"at least as many as population, {settings.population}"
        )
    breeder = Breeder(space, settings)
    return breeder.loop(
        lambda parents: _vary_or(breeder, settings, parents, n_offspring),
        lambda parents, offspring: breeder.select(offspring) if parents else offspring,
    )


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
    breeder = Breeder(space, settings, GoalIndividual)

    def breed(parents: Sequence[Individual]) -> list[Individual]:
        n_padding = -len(parents) % 4  # the tournament takes four at a time
        padded = [*parents, *islice(cycle(parents), n_padding)]
        with lent_to_deap(breeder.rng):
            selected = tools.selTournamentDCD(padded, len(padded))
        return _vary_and(breeder, settings, selected[: breeder.size])

    return breeder.loop(
        breed,
        lambda parents, offspring: _fittest_by_goals([*parents, *offspring], breeder.size),
    )


def _vary_and(
    breeder: Breeder, settings: CampaignSettings, selected: Sequence[Individual]
) -> list[Individual]:
    toolbox = _own_toolbox(breeder)
    with lent_to_deap(breeder.rng):
        return list(algorithms.varAnd(selected, toolbox, settings.crossover, settings.mutation))


def _vary_or(
    breeder: Breeder, settings: CampaignSettings, parents: Sequence[Individual], n_offspring: int
) -> list[Individual]:
    """Vary by crossover or mutation; their chances share what is above 1 in proportion."""
    toolbox = _own_toolbox(breeder)
    crossover = settings.crossover if len(parents) > 1 else 0.0
    total = max(1.0, crossover + settings.mutation)
    share = crossover / total
    mutation = min(settings.mutation / total, 1.0 - share)
    with lent_to_deap(breeder.rng):
        return list(algorithms.varOr(parents, toolbox, n_offspring, share, mutation))


def _own_toolbox(breeder: Breeder) -> Any:
    """Return the operators; DEAP draws from the search's generator, so they need another."""
    return breeder.toolbox(Random(breeder.rng.getrandbits(64)))


def _fittest_by_goals(individuals: list[Individual], n_selected: int) -> list[Individual]:
    """Return the first by rank and crowding distance, both entered in their fitness."""
    n_goals = len(individuals[0].score.goals)
    sorting = "log" if n_goals > 1 else "standard"  # DEAP's log sort needs two objectives
    return list(tools.selNSGA2(individuals, n_selected, nd=sorting))
