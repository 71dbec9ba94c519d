"""The search algorithms: the paper's, DEAP's, one of our own, and two controls.

References
----------
Source paper, section III-E.
"""

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from random import Random
from types import MappingProxyType
from typing import Any, TypeAlias

from mrsfi_runtime.record.settings import CampaignSettings
from mrsfi_runtime.search.breeding import Breeder
from mrsfi_runtime.search.deap_algorithms import (
    ea_generate_update,
    ea_mu_comma_lambda,
    ea_mu_plus_lambda,
    ea_simple,
    nsga2,
)
from mrsfi_runtime.search.guided import guided
from mrsfi_runtime.search.individuals import Individual
from mrsfi_runtime.search.loop import Algorithm, AlgorithmFactory
from mrsfi_runtime.search.selection import uniform
from mrsfi_runtime.search.space import SearchSpace

_Select: TypeAlias = Callable[[Sequence[Individual]], list[Individual]]


def paper(space: SearchSpace, settings: CampaignSettings) -> Algorithm:
    """Return the paper's loop: select, exchange faults in pairs, mutate, replace all.

    References
    ----------
    Source paper, section III-E. An offspring that variation left as its parent was keeps
    the parent's fitness and is not evaluated again.
    """
    breeder = Breeder(space, settings)
    return _evolution(breeder, settings, breeder.select)


def drift(space: SearchSpace, settings: CampaignSettings) -> Algorithm:
    """Return the paper's loop without selection pressure: variation alone, as a control."""
    breeder = Breeder(space, settings)
    select = partial(uniform, n_selected=breeder.size, rng=breeder.rng)
    return _evolution(breeder, settings, select)


def random_search(space: SearchSpace, settings: CampaignSettings) -> Algorithm:
    """Return a control that draws every generation afresh."""
    breeder = Breeder(space, settings)
    return breeder.loop(lambda _: breeder.first())


def _evolution(breeder: Breeder, settings: CampaignSettings, select: _Select) -> Algorithm:
    rng, toolbox = breeder.rng, breeder.toolbox(breeder.rng)
    return breeder.loop(lambda parents: _varied(select(parents), settings, rng, toolbox))


def _varied(
    selected: Sequence[Individual], settings: CampaignSettings, rng: Random, toolbox: Any
) -> list[Individual]:
    offspring = [toolbox.clone(parent) for parent in selected]
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
