"""The search algorithms: the paper's, DEAP's, ``guided``, and two controls.

Each factory in ``ALGORITHMS`` returns an ``Algorithm`` of ``search.loop``; read that table first.
DEAP's loops evaluate and record by themselves. Here, ``Breeder`` and ``GenerationalLoop`` run one
generation at a time, with the operators that the campaign file names.

The paper's loop loses its best individuals, keeps the faults that it began with, and redraws every
value. ``guided``, mrsfi's own search, begins with faults in their longest windows, at landmarks. It
keeps the best individuals and takes small steps from them. For few goals it keeps a Pareto front.
``FaultModel`` is the distribution that ``eaGenerateUpdate`` learns: which faults, and when.

References
----------
Source paper, section III-E. Larrañaga and Lozano, *Estimation of Distribution Algorithms*, 2002:
univariate models.
"""

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from hashlib import blake2b
from itertools import cycle, islice
from random import Random
from statistics import fmean, pstdev
from types import MappingProxyType
from typing import Any

from deap import algorithms, base, tools

from mrsfi_runtime.errors import UsageError
from mrsfi_runtime.model.faults import Specification, TimedFault
from mrsfi_runtime.record.database import specification_text
from mrsfi_runtime.record.settings import CampaignSettings
from mrsfi_runtime.search.fitness import Score, chosen, errors_by_line
from mrsfi_runtime.search.loop import (
    MUTATIONS,
    SELECTIONS,
    STEPS,
    Algorithm,
    AlgorithmFactory,
    Breeding,
    Criticality,
    GenerationalLoop,
    GenerationSummary,
    Individual,
    Known,
    Memory,
    Step,
    Survival,
    filled,
    foremost,
    grafted,
    lent_to_deap,
    resized,
    uniform,
)
from mrsfi_runtime.search.space import (
    CROSSOVERS,
    SearchSpace,
    crossed,
    first_size,
    random_specification,
    widest,
)

_MEMORY = 0.95  # share of a step's credit that each use keeps


def guided(space: SearchSpace, settings: CampaignSettings) -> Algorithm:
    """Return the search that docs/find-weaknesses.md describes under "Guided".

    If the campaign minimises, NSGA-II selects survivors, all are equally likely parents, and a step
    succeeds if it leads onto the front.
    """
    guide = _Guide(space, settings, Random(settings.seed))
    return GenerationalLoop(settings, guide, guide.breed, guide.survive)


class _Guide(Memory):
    def __init__(self, space: SearchSpace, settings: CampaignSettings, rng: Random) -> None:
        super().__init__(rng)
        self._space = space
        self._n_faults = settings.faults
        self._new_size = partial(first_size, settings, rng)
        self._costs = partial(settings.costs, duration=space.duration)
        self._minimises = settings.minimise is not None
        self._size = settings.population
        self._asked: set[bytes] = set()
        self._niches: dict[tuple[object, ...], tuple[tuple[float, ...], Individual]] = {}
        # With more goals, individuals hardly ever dominate each other
        self._has_few_goals = 0 < len(settings.goals) <= 3
        self._front: dict[Criticality, Individual] = {}
        self._credit = dict.fromkeys(STEPS, 1.0)
        self._bred: list[tuple[Individual, float, list[Step]]] = []

    def breed(self, population: Sequence[Individual]) -> list[Individual]:
        self._bred.clear()
        offspring = []
        for _ in range(self._size):
            individual = self._child(population) if population else self._new()
            self._asked.add(_hash(specification_text(individual.specification)))
            offspring.append(individual)
        return offspring

    def kept(self) -> dict[str, Any]:
        niches = [(niche, rank, each.number) for niche, (rank, each) in self._niches.items()]
        front = [each.number for each in self._front.values()]
        return {"niches": niches, "front": front, "credit": [*self._credit.values()]}

    def restore(self, kept: Mapping[str, Any], known: Known, asked: Iterable[str]) -> None:
        self._asked.update(map(_hash, asked))
        for niche, rank, number in kept["niches"]:
            self._niches[tuple(niche)] = tuple(rank), known(number)
        self._front = {self._aims(each): each for each in map(known, kept["front"])}
        self._credit.update(zip(STEPS, kept["credit"], strict=True))

    def _new(self) -> Individual:
        size = self._new_size()
        if self._has_few_goals:
            return Individual(random_specification(self._space, size, self.rng))
        return Individual(filled(self._space, (), size, self.rng))

    def survive(
        self, population: Sequence[Individual], offspring: list[Individual]
    ) -> list[Individual]:
        for individual in offspring:
            self._enter_niches(individual)
            if self._has_few_goals or self._minimises:
                self._enter_front(individual)
        for individual, parent_fitness, steps in self._bred:
            if individual.is_evaluated:
                is_better = individual.score.fitness > parent_fitness
                if self._minimises:
                    is_better = self._front.get(self._aims(individual)) is individual
                for step in steps:
                    kept = _MEMORY * self._credit[step]
                    self._credit[step] = kept + (1.0 - _MEMORY) * is_better
        first, twins = self._twins_apart([*offspring, *population])
        if self._minimises:
            first = foremost(first, min(self._size, len(first)), self._aims)
        return [*first, *twins][: self._size]

    def _twins_apart(
        self, individuals: Sequence[Individual]
    ) -> tuple[list[Individual], list[Individual]]:
        """Return the fittest two of each goal vector, of equals the first; and the others."""
        n_known: Counter[tuple[float, ...]] = Counter()
        first, rest = list[Individual](), list[Individual]()
        for individual in sorted(individuals, key=_fitness, reverse=True):
            kind = (*individual.score.goals, *self._costs(individual.specification))
            n_known[kind] += 1
            (first if n_known[kind] <= 2 else rest).append(individual)
        return first, rest

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
        """Enter an individual, unless another dominates it; it replaces an equal one."""
        aims = self._aims(individual)
        if any(known.dominates(aims) for known in self._front):
            return
        for known in filter(aims.dominates, [*self._front]):
            del self._front[known]
        self._front[aims] = individual

    def _child(self, population: Sequence[Individual]) -> Individual:
        """Return a child that was not asked for yet; after ten tries, a random individual."""
        for _ in range(10):
            parent = self._parent(population)
            specification, steps = self._varied(parent)
            if _hash(specification_text(specification)) not in self._asked:
                child = Individual(specification)
                self._bred.append((child, _fitness(parent), steps))
                return child
        return self._new()

    def _parent(self, population: Sequence[Individual]) -> Individual:
        if self._niches and self.rng.random() < 0.3:
            best = (individual for _, individual in self._niches.values())
            return self.rng.choice((*best, *self._front.values()))
        if self._minimises:
            return self.rng.choice(population)
        return max((self.rng.choice(population) for _ in range(3)), key=_fitness)  # a tournament

    def _donor(self, parent: Individual) -> Individual:
        """Draw from the front; without one, the best of a goal, more likely if it gains much."""
        if self._front:
            return self.rng.choice(tuple(self._front.values()))
        goals = parent.score.goals
        best = [self._niches["goal", place][1] for place in range(len(goals))]
        gains = [1.0 + each.score.goals[place] - goals[place] for place, each in enumerate(best)]
        return self.rng.choices(best, gains)[0]

    def _varied(self, parent: Individual) -> tuple[Specification, list[Step]]:
        rng, space = self.rng, self._space
        specification = parent.specification
        if rng.random() < 0.25:
            donor = self._donor(parent).specification
            if rng.choice(("exchange", "graft")) == "graft":
                specification = grafted(space, specification, donor, rng)
            else:
                specification, _ = crossed(space, specification, donor, rng)
        if len(specification) < self._n_faults and rng.random() < 0.5:
            specification = filled(space, specification, len(specification) + 1, rng)
        steps: list[Step] = []
        while not steps or rng.random() < 0.5:
            weights = [max(0.05, credit) for credit in self._credit.values()]  # no step dies out
            (step,) = rng.choices(STEPS, weights)
            steps.append(step)
            specification = step(space, specification, rng)
        return specification[: self._n_faults], steps


def _hash(text: str) -> bytes:
    """Return a hash of a specification's text, 16 bytes in place of thousands; 0 equals -0."""
    plain = text.replace("-0.0,", "0.0,").replace("-0.0]", "0.0]")
    return blake2b(plain.encode(), digest_size=16).digest()


def _fitness(individual: Individual) -> float:
    return individual.score.fitness


_RATE = 0.3  # the learning rate

_Gauss = tuple[float, float]


class FaultModel(Memory):
    """The frequency of every pool fault, and Gaussians of its start, finish and values."""

    remembered = ("_chances", "_gaussians")

    def __init__(self, space: SearchSpace, n_faults: int, rng: Random) -> None:
        super().__init__(rng)
        self._space = space
        self._n_faults = n_faults
        self._chances = dict.fromkeys(space.candidates, 1.0)
        last = float(space.duration - 1)
        self._ranges = {
            fault: ((0.0, last), (0.0, last), *candidate.bounds)
            for fault, candidate in space.candidates.items()
        }
        self._gaussians: dict[str, list[_Gauss]] = {
            fault: [((low + high) / 2, (high - low) / 2) for low, high in ranges]
            for fault, ranges in self._ranges.items()
        }

    def generate(self) -> Specification:
        """Draw a specification: faults by their frequency, as long as there is room."""
        placed: list[TimedFault] = []
        candidates = dict(self._chances)
        while candidates and len(placed) < self._n_faults:
            (fault,) = self.rng.choices(tuple(candidates), tuple(candidates.values()))
            timed = self._timed(fault, placed)
            if timed is None:
                del candidates[fault]
            else:
                placed.append(timed)
        return self._space.ordered(placed)

    def _timed(self, fault: str, placed: Sequence[TimedFault]) -> TimedFault | None:
        model = zip(self._gaussians[fault], self._ranges[fault], strict=True)
        drawn = [min(b, max(a, self.rng.gauss(*gaussian))) for gaussian, (a, b) in model]
        start, finish = sorted(map(round, drawn[:2]))
        overlaps = [
            (max(start, first), min(finish, last))
            for first, last in self._space.free_windows(fault, placed)
            if first <= finish and start <= last
        ]
        if not overlaps:
            return None
        values = self._space.candidates[fault].changed(
            drawn[2:],
            lambda value, _low, _high, is_whole: float(round(value)) if is_whole else value,
        )
        return self._space.timed(fault, widest(overlaps), values, self.rng)

    def update(self, population: Sequence[Individual]) -> None:
        """Learn from the difference between the best of a generation and all of it.

        The best alone would mislead: faults that are placed early cut the windows of later ones.
        """
        ranked = sorted(population, key=_fitness, reverse=True)
        elite = ranked[: max(1, round(0.25 * len(ranked)))]
        n_elite = sum(map(len, elite))
        for fault, gaussians in self._gaussians.items():
            among_all, among_best = _rows(fault, ranked), _rows(fault, elite)
            share = len(among_best) * len(self._chances) / n_elite
            chance = (1.0 - _RATE) * self._chances[fault] + _RATE * share
            self._chances[fault] = max(0.1, chance)  # 1 if all faults are equally frequent
            if among_best:
                best, every = zip(*among_best, strict=True), zip(*among_all, strict=True)
                moved = map(_moved, gaussians, best, every, self._ranges[fault])
                self._gaussians[fault] = [*moved]


def _rows(fault: str, individuals: Sequence[Individual]) -> list[tuple[float, ...]]:
    return [
        (timed.start, timed.finish, *timed.values)
        for individual in individuals
        for timed in individual
        if timed.fault == fault
    ]


def _moved(
    old: _Gauss, best: Sequence[float], every: Sequence[float], bounds: tuple[float, float]
) -> _Gauss:
    (middle, spread), (low, high) = old, bounds
    middle += _RATE * (fmean(best) - fmean(every))
    ratio = pstdev(best) / pstdev(every) if pstdev(every) > 0.0 else 1.0
    spread *= 1.0 + _RATE * (min(1.0, ratio) - 1.0)
    return min(high, max(low, middle)), max(0.02 * (high - low), spread)  # it stays above 0


class Breeder(Memory):
    """Draws, varies and selects individuals by a campaign's settings, with one generator."""

    def __init__(self, space: SearchSpace, settings: CampaignSettings) -> None:
        super().__init__(Random(settings.seed))
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
        """Select as many individuals as a population has; they are not copied."""
        return self._select(individuals, self.size, self.rng)

    def toolbox(self, rng: Random) -> Any:
        """Return the operators for DEAP's algorithms; they draw from ``rng``."""
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
        """Vary by crossover or mutation; chances with a sum above 1 are scaled down to it."""
        crossover = self._settings.crossover if len(parents) > 1 else 0.0
        total = max(1.0, crossover + self._settings.mutation)
        share = crossover / total
        mutation = min(self._settings.mutation / total, 1.0 - share)
        return self._by_deap(algorithms.varOr, parents, n_offspring, share, mutation)

    def _by_deap(
        self, vary: Any, individuals: Sequence[Individual], *numbers: float
    ) -> list[Individual]:
        """Let DEAP draw from the search's generator; the operators draw from another one."""
        toolbox = self.toolbox(Random(self.rng.getrandbits(64)))
        with lent_to_deap(self.rng):
            return list(vary(individuals, toolbox, *numbers))

    def loop(
        self, breed: Breeding, survive: Survival = lambda _, offspring: offspring
    ) -> Algorithm:
        """Return the algorithm that draws its first population, and breeds all later ones."""

        def breed_any(parents: Sequence[Individual]) -> list[Individual]:
            return breed(parents) if parents else self.first()

        return GenerationalLoop(self._settings, self, breed_any, survive)


def ea_simple(space: SearchSpace, settings: CampaignSettings) -> Algorithm:
    """Return DEAP's ``eaSimple``: as ``paper``, but all varied individuals are evaluated."""
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
            f"{settings.where('offspring')}: found {n_offspring}; eaMuCommaLambda needs at least "
            f"the size of the population, {settings.population}"
        )
    breeder = Breeder(space, settings)
    return breeder.loop(
        lambda parents: breeder.vary_or(parents, n_offspring),
        lambda parents, offspring: breeder.select(offspring) if parents else offspring,
    )


def ea_generate_update(space: SearchSpace, settings: CampaignSettings) -> Algorithm:
    """Return DEAP's ``eaGenerateUpdate`` on a model of fault windows and values."""
    model = FaultModel(space, settings.faults, Random(settings.seed))

    def breed(_: Sequence[Individual]) -> list[Individual]:
        return [Individual(model.generate()) for _ in range(settings.population)]

    def survive(_: Sequence[Individual], offspring: list[Individual]) -> list[Individual]:
        model.update(offspring)
        return offspring

    return GenerationalLoop(settings, model, breed, survive)


def nsga2(space: SearchSpace, settings: CampaignSettings) -> Algorithm:
    """Return NSGA-II on the goal vector, and on the cost that the settings minimise.

    It does not use the fitness function.

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
    Source paper, section III-E. An offspring that equals its parent keeps the parent's fitness
    and is not evaluated again.
    """
    breeder = Breeder(space, settings)
    return breeder.loop(lambda parents: breeder.varied(breeder.select(parents)))


def drift(space: SearchSpace, settings: CampaignSettings) -> Algorithm:
    """Return the paper's loop without selection pressure: variation alone, as a control."""
    breeder = Breeder(space, settings)
    return breeder.loop(lambda parents: breeder.varied(uniform(parents, breeder.size, breeder.rng)))


def random_search(space: SearchSpace, settings: CampaignSettings) -> Algorithm:
    """Return a control that draws every generation at random."""
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


def begin_search(
    space: SearchSpace,
    settings: CampaignSettings,
    algorithms: Mapping[str, AlgorithmFactory] = ALGORITHMS,
) -> Algorithm:
    """Begin the search that settings name; check its specifications if a part is user-defined."""
    algorithm = chosen(settings, "algorithm", algorithms)(space, settings)
    keys = ("algorithm", "selection", "crossover_operator", "mutation_operator")
    named = ((key, getattr(settings, key)) for key in keys)
    written = [f"{settings.where(key)} {name!r}" for key, name in named if ":" in name]
    return _UserAlgorithm(algorithm, space, " or ".join(written)) if written else algorithm


@dataclass(frozen=True, slots=True)
class _UserAlgorithm:
    algorithm: Algorithm
    space: SearchSpace
    where: str

    @property
    def is_finished(self) -> bool:
        with errors_by_line(self.where):
            return self.algorithm.is_finished

    def ask(self) -> list[Specification]:
        with errors_by_line(self.where):
            asked = self.algorithm.ask()
            return [self.space.require(specification, self.where) for specification in asked]

    def tell(self, scores: Sequence[Score]) -> GenerationSummary:
        with errors_by_line(self.where):
            summary = self.algorithm.tell(scores)
        if not isinstance(summary, GenerationSummary):
            found = type(summary).__name__
            raise UsageError(f"{self.where}: tell returned {found}; expected a GenerationSummary")
        return summary

    def random_state(self) -> str:
        with errors_by_line(self.where):
            return self.algorithm.random_state()
