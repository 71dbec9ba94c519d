"""Probes: what is flown to find the least sets of faults that break each goal.

First each fault is flown alone, in varied forms: most weaknesses are one fault. Then come random
specifications, for each goal by each measure, without a set that is known to break that; what
breaks it nevertheless is reduced to a minimal one, by ddmin. Every flight is judged for all goals.
"""

from collections.abc import Callable, Generator, Iterator
from random import Random

from mrsfi_runtime.causes.cause_set import reduction
from mrsfi_runtime.causes.counts import Column
from mrsfi_runtime.causes.weakness import Broken, FaultSet, Known, form
from mrsfi_runtime.model.faults import Specification
from mrsfi_runtime.search.space import SearchSpace, varied_fault, varied_specification

N_ALONE = 10
"""Forms in which each fault is flown alone before several are flown together."""

_N_TRIES = 100  # draws of what is known already, until there seems to be nothing else


class Probing:
    """Asks for flights, turn by turn, and learns from what they break.

    In each of ``n_alone`` first turns every fault is alone in another form; then one specification
    of at most ``n_faults`` faults for each column, random or ``given``, and half as many faults
    alone.
    """

    def __init__(
        self,
        space: SearchSpace,
        known: Known,
        n_faults: int,
        rng: Random,
        n_alone: int = N_ALONE,
        given: Callable[[Column], Specification | None] = lambda _: None,
    ) -> None:
        self._space = space
        self._known = known
        self._n_faults = n_faults
        self._given = given
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

    def _probe(self, column: Column) -> Generator[Specification, Broken, None]:
        def is_unknown(faults: FaultSet) -> bool:
            return not self._known.has_part_of(column, faults)

        space, most, rng = self._space, self._n_faults, self._rng
        while True:
            drawn = self._given(column) or varied_specification(space, most, rng, is_unknown)
            if column not in (yield drawn):
                self._known.n_kept[column] += 1
            else:
                yield from self._reduced(column, drawn)

    def _reduced(
        self, column: Column, broken: Specification
    ) -> Generator[Specification, Broken, None]:
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
