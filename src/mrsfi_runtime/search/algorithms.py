"""The search algorithms: the paper's, DEAP's, one of our own, and two controls.

References
----------
Source paper, section III-E.
"""

from collections.abc import Mapping, Sequence
from random import Random
from types import MappingProxyType
from typing import Any

from deap import base

from mrsfi_runtime.record.settings import CampaignSettings
from mrsfi_runtime.search.deap_algorithms import (
    ea_generate_update,
    ea_mu_comma_lambda,
    ea_mu_plus_lambda,
    ea_simple,
    nsga2,
)
from mrsfi_runtime.search.guided import guided
from mrsfi_runtime.search.individuals import Individual, mate, mutate
from mrsfi_runtime.search.loop import Algorithm, AlgorithmFactory, GenerationalLoop
from mrsfi_runtime.search.selection import SELECTIONS, Selection, uniform
from mrsfi_runtime.search.space import SearchSpace
from mrsfi_runtime.search.specifications import random_specification
from mrsfi_runtime.search.steps import MUTATIONS
from mrsfi_runtime.search.user_functions import chosen
from mrsfi_runtime.search.variation import CROSSOVERS


def paper(space: SearchSpace, settings: CampaignSettings) -> Algorithm:
    """Return the paper's loop: select, exchange faults in pairs, mutate, replace all.

    References
    ----------
    Source paper, section III-E. An offspring that variation left as its parent was keeps
    the parent's fitness and is not evaluated again.
    """
    return _evolution(space, settings, chosen(settings, "selection", SELECTIONS))


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
    toolbox.register("select", lambda parents: select(parents, settings.population, rng))
    toolbox.register("clone", Individual.clone)
    toolbox.register(
        "mate",
        mate,
        space=space,
        rng=rng,
        operator=chosen(settings, "crossover_operator", CROSSOVERS),
    )
    toolbox.register(
        "mutate",
        mutate,
        space=space,
        rng=rng,
        share=settings.mutation_share,
        operator=chosen(settings, "mutation_operator", MUTATIONS),
    )
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
"""Algorithms by their name in a campaign file."""
