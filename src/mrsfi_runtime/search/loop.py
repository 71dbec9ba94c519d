"""The loop of generations that most searches are, its individuals, and steps that vary them.

An ``Algorithm`` asks for the scores of fault specifications and receives them; it neither
evaluates nor records. With the same seed and scores it asks the same, so a run is repeated or
resumed by giving it the recorded scores. ``GenerationalLoop`` is the usual algorithm.

An individual is a list of immutable timed faults with a fitness. Its classes are plain ones,
because ``deap.creator`` keeps classes in a global registry. DEAP draws from Python's global
random generator, so ``lent_to_deap`` lends that the search's own state for a selection.

A step takes a specification and returns another one that keeps the restriction.

References
----------
Source paper, sections III-E a) and d).
"""

import json
import random
import statistics
from bisect import bisect_right
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from itertools import accumulate
from operator import attrgetter
from random import Random
from types import MappingProxyType
from typing import Protocol, Self, TypeAlias

from deap import base, tools

from mrsfi_runtime.errors import EvaluationError
from mrsfi_runtime.model.faults import Specification, TimedFault
from mrsfi_runtime.record.settings import CampaignSettings
from mrsfi_runtime.search.fitness import Score
from mrsfi_runtime.search.space import (
    Mutation,
    SearchSpace,
    Window,
    freely_mutated,
    mutated,
    random_window,
    transformed,
    widest,
    within,
)


class Criticality(base.Fitness):  # type: ignore[misc]  # DEAP has no types
    """How critical a fault specification is: numbers of which more is, then ``costs``, less."""

    def __init__(self, values: Sequence[float] = (), costs: Sequence[int] = ()) -> None:
        self.weights = (1.0,) * len(values) + (-1.0,) * len(costs)
        super().__init__((*values, *costs))


class Individual(list[TimedFault]):
    """A fault specification in evolution, in the order of ``SearchSpace.ordered``.

    DEAP compares ``fitness``, which has no value until the individual is evaluated; ``score`` is
    the last one. ``number`` counts from 0 the specifications that the algorithm asked for.
    """

    def __init__(self, specification: Specification) -> None:
        super().__init__(specification)
        self.fitness: base.Fitness = Criticality()
        self.score = Score(0.0, ())
        self.number: int | None = None

    @property
    def specification(self) -> Specification:
        """The timed faults as an immutable value."""
        return tuple(self)

    @property
    def is_evaluated(self) -> bool:
        """Whether the fitness is known."""
        return bool(self.fitness.valid)

    def assess(self, score: Score) -> None:
        """Take the score."""
        self.score = score
        self.fitness = Criticality((score.fitness,))

    def become(self, specification: Specification) -> None:
        """Take the timed faults of another; the fitness is lost if they differ."""
        if specification != self.specification:
            self[:] = specification
            del self.fitness.values
            self.number = None

    def clone(self) -> Self:
        """Return a copy that shares the immutable timed faults."""
        copy = type(self)(self.specification)
        if self.is_evaluated:
            copy.assess(self.score)
        copy.number = self.number
        return copy


def foremost(
    individuals: Sequence[Individual],
    n_selected: int,
    objectives: Callable[[Individual], Criticality],
) -> list[Individual]:
    """Return the first by rank and crowding distance, both entered in their fitness."""
    for individual in individuals:
        individual.fitness = objectives(individual)  # what DEAP compares them by
    n_objectives = len(individuals[0].fitness.weights)
    sorting = "log" if n_objectives > 1 else "standard"  # DEAP's log sort needs two objectives
    return list(tools.selNSGA2(individuals, n_selected, nd=sorting))


Selection: TypeAlias = Callable[[Sequence[Individual], int, Random], list[Individual]]
"""Selects individuals, themselves and not copies: clone before varying."""


@contextmanager
def lent_to_deap(rng: Random) -> Iterator[None]:
    """Let Python's global generator continue another one, then give both their own back."""
    kept = random.getstate()
    random.setstate(rng.getstate())
    try:
        yield
    finally:
        rng.setstate(random.getstate())
        random.setstate(kept)


def roulette(individuals: Sequence[Individual], n_selected: int, rng: Random) -> list[Individual]:
    """Select by spins of a roulette whose slots are as wide as the fitness.

    It selects as DEAP's does, but adds up one after the other: ``sum`` rounds floats otherwise
    since Python 3.12. If all fitness is 0, selection is uniform, where DEAP's would return nobody.
    """
    lowest = min(individual.fitness.values[0] for individual in individuals)
    if lowest < 0:
        raise EvaluationError(f"roulette selection needs fitness >= 0; found {lowest}")
    if not any(individual.fitness.values[0] for individual in individuals):
        return uniform(individuals, n_selected, rng)
    ranked = sorted(individuals, key=attrgetter("fitness"), reverse=True)
    ends = list(accumulate(individual.fitness.values[0] for individual in ranked))
    *_, total = accumulate(individual.fitness.values[0] for individual in individuals)
    selected: list[Individual] = []
    while len(selected) < n_selected:
        slot = bisect_right(ends, rng.random() * total)
        if slot < len(ranked):  # by rounding, a spin can end behind the last slot
            selected.append(ranked[slot])
    return selected


def uniform(individuals: Sequence[Individual], n_selected: int, rng: Random) -> list[Individual]:
    """Select without regard to fitness."""
    with lent_to_deap(rng):
        return list(tools.selRandom(individuals, n_selected))


def tournament(individuals: Sequence[Individual], n_selected: int, rng: Random) -> list[Individual]:
    """Select the best of three drawn at random, again and again."""
    with lent_to_deap(rng):
        return list(tools.selTournament(individuals, n_selected, tournsize=3))


def best(individuals: Sequence[Individual], n_selected: int, rng: Random) -> list[Individual]:  # noqa: ARG001 - Selection
    """Select the best, each once."""
    return list(tools.selBest(individuals, n_selected))


SELECTIONS: Mapping[str, Selection] = MappingProxyType(
    {"roulette": roulette, "tournament": tournament, "best": best, "uniform": uniform}
)
"""Selections by their name in a campaign file."""


MOST_IDLE = 1000
"""Generations in a row without a new specification after which a search gives up."""


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
        mean, std = statistics.fmean(fitness), statistics.pstdev(fitness)
        found = {"mean": mean, "std": std, "min": min(fitness), "max": max(fitness)}
        return cls(index, {"n_evaluations": n_evaluations, **found}, tuple(population))


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

    The run ends ``settings.generations`` after the first population, generation 0. If
    ``settings.evaluations`` is set, it ends after exactly that many, leaving out individuals of the
    last generation, or after ``MOST_IDLE`` generations in a row that ask for nothing.
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
        fitness = [each.score.fitness for each in self._population]
        numbers = [each.number for each in self._population if each.number is not None]
        self._n_closed += 1
        self._n_idle = 0 if self._pending else self._n_idle + 1
        return GenerationSummary.of(self._n_closed - 1, len(self._pending), fitness, numbers)

    def random_state(self) -> str:
        """Return the state of the random generator as JSON text."""
        return json.dumps(self._rng.getstate())


AlgorithmFactory: TypeAlias = Callable[[SearchSpace, CampaignSettings], Algorithm]
"""Begins a search."""


Step: TypeAlias = Callable[[SearchSpace, Specification, Random], Specification]
"""From a specification another one of at most the same size."""

_SPREAD = 0.1  # standard deviation of a Gaussian step, as a share of the range


def swapped(space: SearchSpace, specification: Specification, rng: Random) -> Specification:
    """Put a fault of the pool in the place of one, wherever it fits longest."""
    kept = list(specification)
    if kept:
        kept.pop(rng.randrange(len(kept)))
    return filled(space, tuple(kept), len(specification), rng)


def forced(space: SearchSpace, specification: Specification, rng: Random) -> Specification:
    """Have a fault of the pool active all the time; what conflicts with it leaves."""
    fault = rng.choice(tuple(space.candidates))
    values = _landmark(space, fault, specification, rng)
    timed = space.timed(fault, (0, space.duration - 1), values, rng)
    kept = [other for other in specification if not space.clash(timed, other)]
    if len(kept) == len(specification) and kept:
        kept.pop(rng.randrange(len(kept)))
    return space.ordered([timed, *kept])


def dropped(space: SearchSpace, specification: Specification, rng: Random) -> Specification:
    """Leave one fault out, unless it is the only one; others stretch into its place."""
    if len(specification) < 2:
        return specification
    place = rng.randrange(len(specification))
    left = specification[:place] + specification[place + 1 :]
    conflicts = space.candidates[specification[place].fault].conflicts
    for timed in left:
        if timed.fault in conflicts:
            others = [other for other in left if other != timed]
            left = space.ordered([*others, _wide(space, timed, tuple(others), rng)])
    return left


def resized(
    space: SearchSpace,
    specification: Specification,
    rng: Random,
    share: float,
    *,
    mutation: Mutation,
    n_most: int,
) -> Specification:
    """Mutate, and leave a fault out, add one up to a most, or do neither, equally often."""
    changed = mutation(space, specification, rng, share)
    difference = rng.choice((-1, 0, 1))
    if difference < 0:
        return dropped(space, changed, rng)
    return filled(space, changed, min(n_most, len(changed) + difference), rng)


def grafted(
    space: SearchSpace, specification: Specification, donor: Specification, rng: Random
) -> Specification:
    """Take over a few faults of a donor; what conflicts with them leaves, then others at random.

    What comes out is at most of the size of the larger one.
    """
    taken = rng.sample(donor, min(len(donor), rng.randint(1, 3)))
    kept = [each for each in specification if not any(space.clash(each, one) for one in taken)]
    while len(kept) + len(taken) > max(len(specification), len(donor)):
        kept.pop(rng.randrange(len(kept)))
    return space.ordered([*taken, *kept])


def filled(
    space: SearchSpace, specification: Specification, n_faults: int, rng: Random
) -> Specification:
    """Add faults of the pool up to a number, as long as there is room, in longest free windows."""
    placed = list(specification)
    candidates = list(space.candidates)
    while candidates and len(placed) < n_faults:
        fault = candidates.pop(rng.randrange(len(candidates)))
        free = space.free_windows(fault, placed)
        if free:
            values = _landmark(space, fault, tuple(placed), rng)
            placed.append(space.timed(fault, widest(free), values, rng))
    return space.ordered(placed)


def crept(
    space: SearchSpace, specification: Specification, rng: Random, share: float = 0.5
) -> Specification:
    """Mutate by Gaussian steps, jumps and wider windows in place of values drawn anew."""
    faults = list(specification)
    for place, timed in enumerate(faults):
        if rng.random() < share:
            change = rng.choice((_wide, _shifted, _jumped))
            others = tuple(faults[:place] + faults[place + 1 :])
            faults[place] = change(space, timed, others, rng)
    return space.ordered(faults)


_Change: TypeAlias = Callable[[SearchSpace, TimedFault, Specification, Random], TimedFault]


def _changed(
    change: _Change, space: SearchSpace, specification: Specification, rng: Random
) -> Specification:
    if not specification:
        return specification
    place = rng.randrange(len(specification))
    others = specification[:place] + specification[place + 1 :]
    return space.ordered([*others, change(space, specification[place], others, rng)])


def _room(space: SearchSpace, timed: TimedFault, others: Specification) -> Window:
    """Return the free window that a placed fault lies in."""
    free = space.free_windows(timed.fault, others)
    return next(window for window in free if window[0] <= timed.start <= window[1])


def _wide(space: SearchSpace, timed: TimedFault, others: Specification, _: Random) -> TimedFault:
    start, finish = _room(space, timed, others)
    return timed._replace(start=start, finish=finish)


def _shifted(
    space: SearchSpace, timed: TimedFault, others: Specification, rng: Random
) -> TimedFault:
    first, last = _room(space, timed, others)
    ticks = (
        min(last, max(first, round(rng.gauss(tick, _SPREAD * space.duration))))
        for tick in (timed.start, timed.finish)
    )
    start, finish = sorted(ticks)

    def stepped(value: float, low: float, high: float, is_integer: bool) -> float:
        step = rng.gauss(value, _SPREAD * (high - low))
        return min(high, max(low, float(round(step)) if is_integer else step))

    values = space.candidates[timed.fault].changed(timed.values, stepped)
    return timed._replace(start=start, finish=finish, values=values)


def _redrawn(
    space: SearchSpace, timed: TimedFault, others: Specification, rng: Random
) -> TimedFault:
    window = random_window(space.free_windows(timed.fault, others), rng)
    return space.timed(timed.fault, window, timed.values, rng)


def _jumped(
    space: SearchSpace, timed: TimedFault, others: Specification, rng: Random
) -> TimedFault:
    values = _landmark(space, timed.fault, others, rng)
    return space.timed(timed.fault, (timed.start, timed.finish), values, rng)


def _landmark(
    space: SearchSpace, fault: str, others: Specification, rng: Random
) -> tuple[float, ...]:
    """Draw values that mean something in the mission, or in the specification."""
    candidate = space.candidates[fault]
    if candidate.is_place and rng.random() < 0.5:
        places = [
            (*other.values[:2], *candidate.values[2:])
            for other in others
            if space.candidates[other.fault].is_place
            and all(map(within, other.values[:2], candidate.bounds[:2]))
        ]
        if places:
            return rng.choice(places)
    return rng.choice(candidate.landmarks)


widened: Step = partial(_changed, _wide)
"""Stretch the window of one fault as far as the others let it."""

shifted: Step = partial(_changed, _shifted)
"""Move the window and values of one fault by a Gaussian step."""

redrawn: Step = partial(_changed, _redrawn)
"""Draw the window of one fault anew, and its trigger."""

jumped: Step = partial(_changed, _jumped)
"""Let the values of one fault jump to a landmark, or to the place of another fault, and its trigger
to any."""

STEPS: tuple[Step, ...] = (widened, shifted, redrawn, jumped, swapped, forced, dropped)
"""All steps."""

MUTATIONS: Mapping[str, Mutation] = MappingProxyType(
    {"redraw": mutated, "creep": crept, "free": freely_mutated, "transform": transformed}
)
"""Mutations by their name in a campaign file."""
