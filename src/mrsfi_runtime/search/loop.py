"""The generational loop of most search algorithms, its individuals, and steps that vary them.

An ``Algorithm`` asks for the scores of fault specifications and receives them; it neither
evaluates nor records. The same seed and scores lead to the same specifications. So the recorded
scores suffice to repeat a run. ``GenerationalLoop`` is the usual one; it can go on from a state.

An individual is a list of immutable timed faults with a fitness. Its classes are plain Python,
because ``deap.creator`` keeps classes in a global registry. DEAP draws from Python's global
random generator; ``lent_to_deap`` lends it the state of the search's generator.

A step changes a specification; conflicting faults still never overlap in the result.

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
from typing import Any, Protocol, Self, TypeAlias

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
    """How critical a fault specification is: ``values`` to maximise, ``costs`` to minimise."""

    def __init__(self, values: Sequence[float] = (), costs: Sequence[int] = ()) -> None:
        self.weights = (1.0,) * len(values) + (-1.0,) * len(costs)
        super().__init__((*values, *costs))


class Individual(list[TimedFault]):
    """A fault specification under evolution, in the order of ``SearchSpace.ordered``.

    DEAP compares ``fitness``, which has no value until the individual is evaluated; ``score`` is
    the latest score. ``number`` counts, from 0, the specifications that the algorithm asked for.
    """

    def __init__(
        self, specification: Specification, score: Score | None = None, number: int | None = None
    ) -> None:
        super().__init__(specification)
        self.fitness: base.Fitness = Criticality((score.fitness,) if score else ())
        self.score = score or Score(0.0, ())
        self.number = number

    @property
    def specification(self) -> Specification:
        """The timed faults as an immutable value."""
        return tuple(self)

    @property
    def is_evaluated(self) -> bool:
        """Whether the fitness is known."""
        return bool(self.fitness.valid)

    def assess(self, score: Score) -> None:
        """Set the score, and the fitness with it."""
        self.score = score
        self.fitness = Criticality((score.fitness,))

    def become(self, specification: Specification) -> None:
        """Replace the timed faults; if they differ, the individual has no fitness any more."""
        if specification != self.specification:
            self[:] = specification
            del self.fitness.values
            self.number = None

    def clone(self) -> Self:
        """Return a copy that shares the immutable timed faults."""
        score = self.score if self.is_evaluated else None
        return type(self)(self.specification, score, self.number)


def foremost(
    individuals: Sequence[Individual],
    n_selected: int,
    objectives: Callable[[Individual], Criticality],
) -> list[Individual]:
    """Return the best by Pareto rank and crowding distance; sets the fitness of all."""
    for individual in individuals:
        individual.fitness = objectives(individual)  # which DEAP compares
    n_objectives = len(individuals[0].fitness.weights)
    sorting = "log" if n_objectives > 1 else "standard"  # DEAP's log sort needs two objectives
    return list(tools.selNSGA2(individuals, n_selected, nd=sorting))


Selection: TypeAlias = Callable[[Sequence[Individual], int, Random], list[Individual]]
"""Selects individuals; it returns no copies, so clone them before varying."""


@contextmanager
def lent_to_deap(rng: Random) -> Iterator[None]:
    """Lend the state of ``rng`` to Python's global generator, then move ``rng`` on to its end."""
    kept = random.getstate()
    random.setstate(rng.getstate())
    try:
        yield
    finally:
        rng.setstate(random.getstate())
        random.setstate(kept)


def roulette(individuals: Sequence[Individual], n_selected: int, rng: Random) -> list[Individual]:
    """Select individuals with probabilities proportional to their fitness.

    It selects as DEAP's roulette, but adds floats one by one, because ``sum`` rounds differently
    since Python 3.12. If every fitness is 0, it selects uniformly; DEAP's would select none.
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
        if slot < len(ranked):  # rounding can place a spin beyond the last slot
            selected.append(ranked[slot])
    return selected


def uniform(individuals: Sequence[Individual], n_selected: int, rng: Random) -> list[Individual]:
    """Select without regard to fitness."""
    with lent_to_deap(rng):
        return list(tools.selRandom(individuals, n_selected))


def tournament(individuals: Sequence[Individual], n_selected: int, rng: Random) -> list[Individual]:
    """Select, each time, the best of three individuals drawn at random."""
    with lent_to_deap(rng):
        return list(tools.selTournament(individuals, n_selected, tournsize=3))


def best(individuals: Sequence[Individual], n_selected: int, rng: Random) -> list[Individual]:  # noqa: ARG001 - Selection
    """Select the best individuals, each once."""
    return list(tools.selBest(individuals, n_selected))


SELECTIONS: Mapping[str, Selection] = MappingProxyType(
    {"roulette": roulette, "tournament": tournament, "best": best, "uniform": uniform}
)
"""Selections by their name in a campaign file."""


MOST_IDLE = 1000
"""Generations in a row without a new specification after which a search gives up."""


@dataclass(frozen=True, slots=True)
class GenerationSummary:
    """An evaluated generation.

    ``statistics`` has ``n_evaluations``, the number of specifications asked for, and ``mean``,
    ``std``, ``min`` and ``max`` of the population's fitness. ``population`` has the number of each
    individual's specification, counted from 0 over the whole search.
    """

    index: int
    statistics: Mapping[str, float]
    population: tuple[int, ...]

    @classmethod
    def of(
        cls, index: int, n_evaluations: int, fitness: Sequence[float], population: Iterable[int]
    ) -> Self:
        """Return the summary of a population by its fitness and the numbers of its individuals."""
        mean, std = statistics.fmean(fitness), statistics.pstdev(fitness)
        values = {"mean": mean, "std": std, "min": min(fitness), "max": max(fitness)}
        return cls(index, {"n_evaluations": n_evaluations, **values}, tuple(population))


class Algorithm(Protocol):
    """A search, in turns of ``ask``, evaluate and ``tell``, until it is finished."""

    @property
    def is_finished(self) -> bool:
        """Whether the search has ended."""

    def ask(self) -> list[Specification]:
        """Return the specifications of the next generation that need evaluation."""

    def tell(self, scores: Sequence[Score]) -> GenerationSummary:
        """Receive their scores, in the same order, and end the generation."""

    def random_state(self) -> str:
        """Return the state of the random generator as JSON text."""


Breeding: TypeAlias = Callable[[Sequence[Individual]], list[Individual]]
"""Returns the offspring of a population, which is empty at first; new individuals are evaluated."""

Survival: TypeAlias = Callable[[Sequence[Individual], list[Individual]], list[Individual]]
"""Returns the next population, not empty, from a population and its evaluated offspring."""


Known: TypeAlias = Callable[[int], Individual]
"""Returns an evaluated individual by the number of its specification."""


class Memory:
    """What a search has besides its population: a random generator, and what it remembers."""

    remembered: tuple[str, ...] = ()  # names of attributes, as JSON keeps them

    def __init__(self, rng: Random) -> None:
        self.rng = rng

    def kept(self) -> dict[str, Any]:
        """Return what it remembers, without all that was asked for."""
        return {name: getattr(self, name) for name in self.remembered}

    def restore(self, kept: Mapping[str, Any], known: Known, asked: Iterable[str]) -> None:  # noqa: ARG002 - of others
        """Remember what was kept; ``asked`` has the texts of all specifications asked for."""
        vars(self).update(kept)


class GenerationalLoop:
    """An algorithm that breeds offspring, and selects survivors from offspring and population.

    It ends ``settings.generations`` generations after the first one, generation 0. If
    ``settings.evaluations`` is set, it ends after exactly that many, where it may cut the last
    generation short, or after ``MOST_IDLE`` generations in a row without a new specification.
    """

    def __init__(
        self, settings: CampaignSettings, memory: Memory, breed: Breeding, survive: Survival
    ) -> None:
        self._settings = settings
        self._memory = memory
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
        """Whether generations or evaluations are used up, or no new specifications are bred."""
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
        """Receive the scores of the specifications asked for, in the same order."""
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
        return json.dumps(self._memory.rng.getstate())

    def state(self) -> dict[str, Any]:
        """Return what ``restore`` needs to go on from here, as JSON keeps it."""
        counts = self._n_asked, self._n_closed, self._n_idle
        population = [(each.number, vars(each.fitness)) for each in self._population]
        random, memory = self._memory.rng.getstate(), self._memory.kept()
        return {"counts": counts, "random": random, "population": population, "memory": memory}

    def restore(self, state: Mapping[str, Any], known: Known, asked: Iterable[str]) -> None:
        """Go on from a state; ``asked`` has the texts of all specifications asked for."""
        self._n_asked, self._n_closed, self._n_idle = state["counts"]
        version, numbers, gauss = state["random"]
        self._memory.rng.setstate((version, tuple(numbers), gauss))
        for number, fitness in state["population"]:
            individual = known(number).clone()
            vars(individual.fitness).update(fitness, wvalues=tuple(fitness["wvalues"]))
            self._population.append(individual)
        self._memory.restore(state["memory"], known, asked)


AlgorithmFactory: TypeAlias = Callable[[SearchSpace, CampaignSettings], Algorithm]
"""Begins a search."""


Step: TypeAlias = Callable[[SearchSpace, Specification, Random], Specification]
"""Returns a changed specification of at most the same size; neither is ever empty."""

_SPREAD = 0.1  # standard deviation of a Gaussian step, as a share of the range


def swapped(space: SearchSpace, specification: Specification, rng: Random) -> Specification:
    """Replace one fault by a fault of the pool, in the longest window that is free."""
    kept = list(specification)
    kept.pop(rng.randrange(len(kept)))
    return filled(space, tuple(kept), len(specification), rng)


def forced(space: SearchSpace, specification: Specification, rng: Random) -> Specification:
    """Make a fault of the pool active for the whole mission; remove faults that conflict."""
    fault = rng.choice(tuple(space.candidates))
    values = _landmark(space, fault, specification, rng)
    timed = space.timed(fault, (0, space.duration - 1), values, rng)
    kept = [other for other in specification if not space.clash(timed, other)]
    if len(kept) == len(specification):
        kept.pop(rng.randrange(len(kept)))
    return space.ordered([timed, *kept])


def dropped(space: SearchSpace, specification: Specification, rng: Random) -> Specification:
    """Remove one fault, unless it is the only one, and widen the faults that conflicted with it."""
    if len(specification) < 2:
        return specification
    place = rng.randrange(len(specification))
    rest = specification[:place] + specification[place + 1 :]
    conflicts = space.candidates[specification[place].fault].conflicts
    for timed in rest:
        if timed.fault in conflicts:
            others = [other for other in rest if other != timed]
            rest = space.ordered([*others, _wide(space, timed, tuple(others), rng)])
    return rest


def resized(
    space: SearchSpace,
    specification: Specification,
    rng: Random,
    share: float,
    *,
    mutation: Mutation,
    n_most: int,
) -> Specification:
    """Mutate; then, equally often, remove a fault, add one up to ``n_most``, or do neither."""
    changed = mutation(space, specification, rng, share)
    difference = rng.choice((-1, 0, 1))
    if difference < 0:
        return dropped(space, changed, rng)
    return filled(space, changed, min(n_most, len(changed) + difference), rng)


def grafted(
    space: SearchSpace, specification: Specification, donor: Specification, rng: Random
) -> Specification:
    """Add one to three faults of a donor; remove faults that conflict with them.

    Further faults leave at random until the result is no larger than the larger of the two.
    """
    taken = rng.sample(donor, min(len(donor), rng.randint(1, 3)))
    kept = [each for each in specification if not any(space.clash(each, one) for one in taken)]
    while len(kept) + len(taken) > max(len(specification), len(donor)):
        kept.pop(rng.randrange(len(kept)))
    return space.ordered([*taken, *kept])


def filled(
    space: SearchSpace, specification: Specification, n_faults: int, rng: Random
) -> Specification:
    """Add faults of the pool in their longest free windows, up to ``n_faults`` if there is room."""
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
    """Mutate by wider windows, Gaussian steps and jumps, in place of redrawn values."""
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
    place = rng.randrange(len(specification))
    others = specification[:place] + specification[place + 1 :]
    return space.ordered([*others, change(space, specification[place], others, rng)])


def _room(space: SearchSpace, timed: TimedFault, others: Specification) -> Window:
    """Return the free window around a placed fault."""
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
    """Draw a landmark of a fault, or the place of another fault in the specification."""
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
"""Widen the window of one fault as far as the others allow."""

shifted: Step = partial(_changed, _shifted)
"""Move the window and values of one fault by a Gaussian step."""

redrawn: Step = partial(_changed, _redrawn)
"""Redraw the window of one fault, and its trigger."""

jumped: Step = partial(_changed, _jumped)
"""Set the values of one fault to a landmark or another fault's place, and redraw its trigger."""

STEPS: tuple[Step, ...] = (widened, shifted, redrawn, jumped, swapped, forced, dropped)
"""All steps."""

MUTATIONS: Mapping[str, Mutation] = MappingProxyType(
    {"redraw": mutated, "creep": crept, "free": freely_mutated, "transform": transformed}
)
"""Mutations by their name in a campaign file."""
