"""Controls that tell where ``guided`` begins from how it searches.

Algorithms for ``mrsfi compare``, named ``first_populations:NAME`` with this folder on the path of
Python:

- ``long_windows``: random search with windows as long as they fit; values are the pool's, as in
  plain random search.
- ``landmarks``: random search with values at landmarks; windows are drawn.
- ``both``: random search with both, which is how ``guided`` draws its first population where it
  keeps no front.
- ``from_chance``: ``guided`` with the first population of plain random search.

For example, from the project's folder::

    PYTHONPATH=benchmarks mrsfi compare uuv_sampling --algorithms guided,first_populations:both
"""

from collections.abc import Callable
from random import Random
from typing import TypeAlias

from mrsfi_runtime.model.faults import Specification
from mrsfi_runtime.record.settings import CampaignSettings
from mrsfi_runtime.search.guided import _Guide
from mrsfi_runtime.search.individuals import Individual
from mrsfi_runtime.search.loop import Algorithm, GenerationalLoop
from mrsfi_runtime.search.space import SearchSpace
from mrsfi_runtime.search.specifications import random_specification
from mrsfi_runtime.search.steps import filled

_Draw: TypeAlias = Callable[[SearchSpace, int, Random], Specification]


def long_windows(space: SearchSpace, settings: CampaignSettings) -> Algorithm:
    """Return random search with windows as long as they fit."""
    return _random_search(space, settings, _long)


def landmarks(space: SearchSpace, settings: CampaignSettings) -> Algorithm:
    """Return random search with values at landmarks."""
    return _random_search(space, settings, _at_landmarks)


def both(space: SearchSpace, settings: CampaignSettings) -> Algorithm:
    """Return random search that draws as ``guided`` draws its first population."""
    return _random_search(space, settings, _long_at_landmarks)


def from_chance(space: SearchSpace, settings: CampaignSettings) -> Algorithm:
    """Return ``guided`` with the first population of random search."""
    rng = Random(settings.seed)
    guide = _FromChance(space, settings, rng)
    return GenerationalLoop(settings, rng, guide.breed, guide.survive)


class _FromChance(_Guide):
    def _new(self) -> Individual:
        return Individual(random_specification(self._space, self._n_faults, self._rng))


def _random_search(space: SearchSpace, settings: CampaignSettings, draw: _Draw) -> Algorithm:
    rng = Random(settings.seed)

    def breed(_: object) -> list[Individual]:
        n_drawn = settings.population
        return [Individual(draw(space, settings.faults, rng)) for _ in range(n_drawn)]

    return GenerationalLoop(settings, rng, breed)


def _long_at_landmarks(space: SearchSpace, n_faults: int, rng: Random) -> Specification:
    return filled(space, (), n_faults, rng)


def _long(space: SearchSpace, n_faults: int, rng: Random) -> Specification:
    placed = filled(space, (), n_faults, rng)
    return tuple(timed._replace(values=space.candidates[timed.fault].values) for timed in placed)


def _at_landmarks(space: SearchSpace, n_faults: int, rng: Random) -> Specification:
    placed = random_specification(space, n_faults, rng)
    return tuple(
        timed._replace(values=rng.choice(space.candidates[timed.fault].landmarks))
        for timed in placed
    )
