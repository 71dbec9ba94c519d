"""The search ``cover``: all the ways in which goals break, without a fitness.

First it flies each fault alone, in varied forms: most weaknesses are one fault. Then it draws, for
each goal by each measure, random specifications without a set that is known to break that, and
reduces what breaks it nevertheless to a minimal one. Every flight is judged for all goals.

References
----------
The reduction is ddmin, see ``cause_set``.
"""

import json
import statistics
from collections.abc import Callable, Generator, Iterator, Mapping, Sequence
from random import Random
from types import MappingProxyType
from typing import TypeAlias

from mrsfi_runtime.causes.cause_set import reduction
from mrsfi_runtime.causes.counts import Column
from mrsfi_runtime.causes.weakness import Broken, Known, Yardstick, form
from mrsfi_runtime.model.faults import Specification
from mrsfi_runtime.model.outcome import Outcome
from mrsfi_runtime.record.settings import CampaignSettings
from mrsfi_runtime.search import algorithms
from mrsfi_runtime.search.fitness import Score
from mrsfi_runtime.search.loop import AlgorithmFactory, GenerationSummary
from mrsfi_runtime.search.space import SearchSpace
from mrsfi_runtime.search.specifications import varied_fault, varied_specification

N_ALONE = 10
"""Forms in which each fault is flown alone before several are flown together."""

_N_TRIES = 100  # draws of what is known already, until there seems to be nothing else

Draw: TypeAlias = Callable[[Column], Specification]
"""Draws a specification without a set that is known to break a column; empty if there is none."""

_Probe: TypeAlias = Generator[Specification, Broken, None]


class Probing:
    """Asks for flights, turn by turn, and learns from what they break.

    In each of the first turns every fault is alone in another form; then one specification for
    each column, and half as many faults alone.

    Parameters
    ----------
    n_alone
        How many such first turns there are.
    """

    def __init__(
        self, space: SearchSpace, known: Known, draw: Draw, rng: Random, n_alone: int = N_ALONE
    ) -> None:
        self._space = space
        self._known = known
        self._draw = draw
        self._rng = rng
        self._n_first = n_alone
        self._n_turns = 0
        self._probes = {column: self._probe(column) for column in known.sets}
        self._wishes: dict[Column, Specification] = {}
        self._alone = self._faults_in_turn()

    def turn(self) -> list[Specification]:
        """Return what is to be flown next, each form once; nothing if there seems to be no more."""
        for _ in range(self._n_first + 1):
            self._n_turns += 1
            if new := {form(each): each for each in self._wanted()}:
                return [*new.values()]
        return []

    def _wanted(self) -> Iterator[Specification]:
        """Yield what is not flown yet, of a turn."""
        wishes: list[Specification] = []
        n_alone = len(self._space.candidates)
        if self._n_turns > self._n_first:
            wishes = [wish for column in self._probes if (wish := self._wish(column))]
            n_alone = -(-len(self._probes) // 2)
        wanted = (*wishes, *(next(self._alone) for _ in range(n_alone)))
        return (each for each in wanted if form(each) not in self._known.flown)

    def _faults_in_turn(self) -> Iterator[Specification]:
        whole = [(0, self._space.duration - 1)]
        while True:
            for fault in self._space.candidates:
                for _ in range(_N_TRIES):
                    timed = (varied_fault(self._space, fault, whole, self._rng),)
                    if timed not in self._known.flown:
                        break
                yield timed

    def _wish(self, column: Column) -> Specification | None:
        """Return what one column wants flown; ``None`` if it knows all that it draws."""
        probe = self._probes[column]
        wish = self._wishes.get(column)
        for _ in range(_N_TRIES):
            if wish is None:
                wish = next(probe)
            elif form(wish) in self._known.flown:
                wish = probe.send(self._known.flown[form(wish)])
            if wish and form(wish) not in self._known.flown:
                self._wishes[column] = wish
                return wish
        self._wishes[column] = wish or ()
        return None

    def _probe(self, column: Column) -> _Probe:
        while True:
            drawn = self._draw(column)
            if column not in (yield drawn):
                self._known.n_kept[column] += 1
            else:
                yield from self._reduced(column, drawn)

    def _reduced(self, column: Column, broken: Specification) -> _Probe:
        """Reduce what breaks a column to a minimal set, unless it has one that is known by then."""
        faults = tuple(dict.fromkeys(timed.fault for timed in broken))
        trials = reduction(tuple(range(len(faults))))
        trial = next(trials)
        left = frozenset(faults)
        while not self._known.has_part_of(column, left):
            kept = frozenset(faults[place] for place in trial)
            is_broken = column in (yield tuple(each for each in broken if each.fault in kept))
            left = kept if is_broken else left
            try:
                trial = trials.send(is_broken)
            except StopIteration:
                self._known.add(column, left)


class Cover:
    """The algorithm: see the module.

    It ends after as many evaluations as the settings say, or where there is nothing left to try.

    Attributes
    ----------
    known
        What it has learnt until now.
    """

    def __init__(self, space: SearchSpace, settings: CampaignSettings) -> None:
        self._space = space
        self._most = settings.evaluations
        self._n_faults = settings.faults
        self._rng = Random(settings.seed)
        self.known = Known(space.gate.mission)
        self._probing = Probing(space, self.known, self._drawn, self._rng)
        self._yardstick: Yardstick | None = None
        self._n_asked = 0
        self._n_generations = 0
        self._next: list[Specification] = [(), *self._probing.turn()][: self._most]

    @property
    def is_finished(self) -> bool:
        """Whether all evaluations are used up, or all is known."""
        return not self._next

    def ask(self) -> list[Specification]:
        """Return the specifications of the next turn."""
        return self._next

    def tell(self, scores: Sequence[Score]) -> GenerationSummary:
        """Learn what they break, and end the turn."""
        for specification, score in zip(self._next, scores, strict=True):
            broken: Broken = frozenset()
            if score.outcome is not None:
                if not specification:
                    self._yardstick = Yardstick.of(self._space.gate.mission, score.outcome)
                if self._yardstick is not None:
                    broken = self._yardstick.broken(score.outcome)
            self.known.learn(specification, broken)
        first, self._n_asked = self._n_asked, self._n_asked + len(scores)
        fitness = [score.fitness for score in scores]
        self._n_generations += 1
        left = None if self._most is None else self._most - self._n_asked
        self._next = self._probing.turn()[:left]
        return GenerationSummary(
            index=self._n_generations - 1,
            statistics={
                "n_evaluations": len(scores),
                "mean": statistics.fmean(fitness),
                "std": statistics.pstdev(fitness),
                "min": min(fitness),
                "max": max(fitness),
            },
            population=tuple(range(first, self._n_asked)),
        )

    def random_state(self) -> str:
        """Return the state of the random generator as JSON text."""
        return json.dumps(self._rng.getstate())

    def _drawn(self, column: Column) -> Specification:
        def is_allowed(faults: frozenset[str]) -> bool:
            return not self.known.has_part_of(column, faults)

        return varied_specification(self._space, self._n_faults, self._rng, is_allowed)


def covered(
    space: SearchSpace, settings: CampaignSettings, outcomes: Mapping[Specification, Outcome | None]
) -> Known:
    """Return what a search knew after it was told the outcomes of a record; ``None`` is a failure.

    It may have been ended in the midst of a turn.
    """
    search = Cover(space, settings)
    while not search.is_finished and all(each in outcomes for each in search.ask()):
        search.tell([Score(0.0, (), outcomes[each]) for each in search.ask()])
    return search.known


ALGORITHMS: Mapping[str, AlgorithmFactory] = MappingProxyType(
    {**algorithms.ALGORITHMS, "cover": Cover}
)
"""All algorithms by their name in a campaign file, those of ``ALGORITHM_NAMES``."""
