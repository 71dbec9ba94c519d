"""Our own search: long windows and values that mean something, improved by small steps.

The paper's loop forgets its best, cannot choose other faults than it began with, and draws
every value anew. This one begins with faults that are active as long as they may, at
landmarks, keeps the best, and takes small steps from there. Of few goals it keeps a front.
"""

from array import array
from collections import Counter
from collections.abc import Sequence
from functools import partial
from hashlib import blake2b
from random import Random

from mrsfi_runtime.model.faults import Specification
from mrsfi_runtime.record.settings import CampaignSettings
from mrsfi_runtime.search.individuals import Criticality, Individual, foremost
from mrsfi_runtime.search.loop import Algorithm, GenerationalLoop
from mrsfi_runtime.search.space import SearchSpace
from mrsfi_runtime.search.specifications import first_size, random_specification
from mrsfi_runtime.search.steps import STEPS, Step, filled, grafted
from mrsfi_runtime.search.variation import crossed

_TOURNAMENT = 3
_ARCHIVE_SHARE = 0.3  # of parents: from the niches and the front
_CROSSOVER = 0.25  # of children: from two parents
_MORE_STEPS = 0.5  # chance of a further step, again and again
_MEMORY = 0.95  # of a step's credit, at each use
_LEAST = 0.05  # credit that keeps a step in use
_TWINS = 2  # individuals of one goal vector in a population
_MOST_GOALS = 3  # of a front: of more, hardly anything dominates anything
_HALF = 0.5
_ATTEMPTS = 10  # to breed what was not asked for yet


def guided(space: SearchSpace, settings: CampaignSettings) -> Algorithm:
    """Return the search by long windows, landmarks and small steps, as docs/search.md has it.

    If the campaign minimises, NSGA-II's selection says who survives, one survivor is as good a
    parent as another, and a step onto the front succeeds.
    """
    rng = Random(settings.seed)
    guide = _Guide(space, settings, rng)
    return GenerationalLoop(settings, rng, guide.breed, guide.survive)


class _Guide:
    def __init__(self, space: SearchSpace, settings: CampaignSettings, rng: Random) -> None:
        self._space = space
        self._n_faults = settings.faults
        self._new_size = partial(first_size, settings, rng)
        self._costs = partial(settings.costs, duration=space.duration)
        self._minimises = settings.minimise is not None
        self._size = settings.population
        self._rng = rng
        self._asked: set[bytes] = set()
        self._niches: dict[tuple[object, ...], tuple[tuple[float, ...], Individual]] = {}
        self._has_few_goals = 0 < len(settings.goals) <= _MOST_GOALS
        self._front: dict[Criticality, Individual] = {}
        self._credit = dict.fromkeys(STEPS, 1.0)
        self._bred: list[tuple[Individual, float, list[Step]]] = []

    def breed(self, population: Sequence[Individual]) -> list[Individual]:
        self._bred.clear()
        offspring = []
        for _ in range(self._size):
            individual = self._child(population) if population else self._new()
            self._asked.add(self._key(individual.specification))
            offspring.append(individual)
        return offspring

    def _new(self) -> Individual:
        size = self._new_size()
        if self._has_few_goals:
            return Individual(random_specification(self._space, size, self._rng))
        return Individual(filled(self._space, (), size, self._rng))

    def survive(
        self, population: Sequence[Individual], offspring: list[Individual]
    ) -> list[Individual]:
        for individual in offspring:
            self._enter_niches(individual)
            if self._has_few_goals or self._minimises:
                self._enter_front(individual)
        for individual, parent_fitness, steps in self._bred:
            if individual.is_evaluated:
                is_better = self._has_succeeded(individual, parent_fitness)
                for step in steps:
                    kept = _MEMORY * self._credit[step]
                    self._credit[step] = kept + (1.0 - _MEMORY) * is_better
        ranked = sorted([*offspring, *population], key=_fitness, reverse=True)  # new ones first
        first, twins = self._twins_apart(ranked)
        if self._minimises:
            first = foremost(first, min(self._size, len(first)), self._aims)
        return [*first, *twins][: self._size]

    def _twins_apart(
        self, ranked: Sequence[Individual]
    ) -> tuple[list[Individual], list[Individual]]:
        n_seen: Counter[tuple[float, ...]] = Counter()
        first, rest = list[Individual](), list[Individual]()
        for individual in ranked:
            kind = (*individual.score.goals, *self._costs(individual.specification))
            n_seen[kind] += 1
            (first if n_seen[kind] <= _TWINS else rest).append(individual)
        return first, rest

    def _has_succeeded(self, individual: Individual, parent_fitness: float) -> bool:
        if self._minimises:
            return self._front.get(self._aims(individual)) is individual
        return individual.score.fitness > parent_fitness

    def _aims(self, individual: Individual) -> Criticality:
        goals = individual.score.goals
        if not self._has_few_goals:
            goals = (_fitness(individual), sum(violations > 0 for violations in goals))
        return Criticality(goals, self._costs(individual.specification))

    def _enter_niches(self, individual: Individual) -> None:
        goals, fitness = individual.score.goals, individual.score.fitness
        ranks: dict[tuple[object, ...], tuple[float, ...]] = {
            ("pattern", *(violations > 0 for violations in goals)): (fitness,),
            **{("goal", place): (count, fitness) for place, count in enumerate(goals)},
        }
        for niche, rank in ranks.items():
            if niche not in self._niches or rank > self._niches[niche][0]:
                self._niches[niche] = rank, individual

    def _enter_front(self, individual: Individual) -> None:
        """Enter an individual, unless another dominates it; of equal ones the newest."""
        aims = self._aims(individual)
        if any(known.dominates(aims) for known in self._front):
            return
        for known in filter(aims.dominates, [*self._front]):
            del self._front[known]
        self._front[aims] = individual

    def _child(self, population: Sequence[Individual]) -> Individual:
        """Return a child that was not asked for yet, if that is not hard to find."""
        for _ in range(_ATTEMPTS):
            parent = self._parent(population)
            specification, steps = self._varied(parent)
            if self._key(specification) not in self._asked:
                child = Individual(specification)
                self._bred.append((child, _fitness(parent), steps))
                return child
        return self._new()

    def _key(self, specification: Specification) -> bytes:
        """Return 16 bytes that tell a specification: it would take thousands to keep."""
        numbers = array("d")
        for fault, start, finish, values, trigger in specification:
            candidate = self._space.candidates[fault]
            set_off = candidate.triggers.index(trigger)
            numbers.extend((candidate.index, start, finish, len(values), set_off))
            numbers.extend(value + 0.0 for value in values)  # 0 equals -0
        return blake2b(numbers, digest_size=16).digest()

    def _parent(self, population: Sequence[Individual]) -> Individual:
        if self._niches and self._rng.random() < _ARCHIVE_SHARE:
            best = (individual for _, individual in self._niches.values())
            return self._rng.choice((*best, *self._front.values()))
        if self._minimises:
            return self._rng.choice(population)
        drawn = [self._rng.choice(population) for _ in range(_TOURNAMENT)]
        return max(drawn, key=_fitness)

    def _donor(self, parent: Individual) -> Individual:
        """Draw from the front; without one, the best of a goal that the parent violates less."""
        if self._front:
            return self._rng.choice(tuple(self._front.values()))
        goals = parent.score.goals
        best = [self._niches["goal", place][1] for place in range(len(goals))]
        gains = [1.0 + each.score.goals[place] - goals[place] for place, each in enumerate(best)]
        return self._rng.choices(best, gains)[0]

    def _varied(self, parent: Individual) -> tuple[Specification, list[Step]]:
        rng, space = self._rng, self._space
        specification = parent.specification
        if rng.random() < _CROSSOVER:
            donor = self._donor(parent).specification
            if rng.choice(("exchange", "graft")) == "graft":
                specification = grafted(space, specification, donor, rng)
            else:
                specification, _ = crossed(space, specification, donor, rng)
        if len(specification) < self._n_faults and rng.random() < _HALF:
            specification = filled(space, specification, len(specification) + 1, rng)
        steps: list[Step] = []
        while not steps or rng.random() < _MORE_STEPS:
            weights = [max(_LEAST, credit) for credit in self._credit.values()]
            (step,) = rng.choices(STEPS, weights)
            steps.append(step)
            specification = step(space, specification, rng)
        return specification[: self._n_faults], steps


def _fitness(individual: Individual) -> float:
    return individual.score.fitness
