"""The cause set: the faults of a specification without which violations would not be.

References
----------
A. Zeller and R. Hildebrandt, "Simplifying and Isolating Failure-Inducing Input", IEEE Transactions
on Software Engineering 28(2), 2002: the algorithm ddmin, and what 1-minimal means. R. Hodován and
Á. Kiss, "Practical Improvements to the Minimizing Delta Debugging Algorithm", ICSOFT 2016: that it
stays 1-minimal, and takes fewer trials, without trying parts alone.
"""

import math
from collections.abc import Generator, Iterable, Mapping
from dataclasses import dataclass
from fractions import Fraction
from random import Random
from typing import TypeAlias

from mrsfi_runtime.causes.counts import Counts, Flights
from mrsfi_runtime.model.faults import Specification

KEEP = 0.95
"""Share of its violations that a cause set keeps of every goal."""

N_ORDERS = 5
"""Shuffled orders in which other minima are looked for."""

_ORDER_SEED = 1

Places: TypeAlias = tuple[int, ...]
"""Faults of a specification, by their places in it, ascending."""

Floor: TypeAlias = Mapping[int, int]
"""The least that has to be left of counts, by column."""


def floor(counts: Counts, keep: float, columns: Iterable[int]) -> Floor:
    """Return what a set of faults has to keep of counts; columns without violations ask nothing."""
    share = Fraction(str(keep))  # as written: 0.95 of 20 is 19, not a little more
    return {k: math.ceil(share * counts[k]) for k in columns if counts[k]}


@dataclass(frozen=True, slots=True)
class Question:
    """Which faults of a specification some counts are due to, of which a floor has to be left."""

    flights: Flights
    specification: Specification
    floor: Floor

    def is_kept_by(self, places: Iterable[int]) -> bool:
        """Return whether these faults, flown without the others, keep enough of every count."""
        counts = self.flights.counts(chosen(self.specification, places))
        return all(counts[k] >= least for k, least in self.floor.items())

    def minimum(self, order: Iterable[int] | None = None) -> Places:
        """Return a 1-minimal set: without any one of its faults, some count is too low.

        What can go is looked for in the order of the specification, or in another one, which may
        lead to another set.
        """
        places = range(len(self.specification)) if order is None else order
        trials = reduction(tuple(places))
        trial = next(trials)
        while True:
            try:
                trial = trials.send(self.is_kept_by(trial))
            except StopIteration as end:
                return tuple(sorted(end.value))

    def minima(self) -> tuple[Places, ...]:
        """Return the different minima that shuffled orders lead to, as often ``N_ORDERS`` says."""
        random = Random(_ORDER_SEED)
        places = range(len(self.specification))
        orders = [random.sample(places, len(places)) for _ in range(N_ORDERS)]
        return tuple(dict.fromkeys(self.minimum(order) for order in orders))


def chosen(specification: Specification, places: Iterable[int]) -> Specification:
    """Return some faults of a specification, in its order."""
    return tuple(specification[place] for place in sorted(places))


def without(specification: Specification, place: int) -> Specification:
    """Return all faults of a specification but one."""
    return (*specification[:place], *specification[place + 1 :])


def reduction(order: tuple[int, ...]) -> Generator[tuple[int, ...], bool, tuple[int, ...]]:
    """Yield parts of an order, be told which are kept, and return a 1-minimal one of those.

    Parts are left out, first halves, at last single faults, from the back to the front, so that
    of faults that do the same the earlier stay, until no single one can be.
    """
    if (yield ()):
        return ()
    left, size = order, (len(order) + 1) // 2
    while True:
        n_before = len(left)
        for last in range(n_before, 0, -size):
            rest = (*left[: max(0, last - size)], *left[last:])
            if (yield rest):
                left = rest
        if size == 1 and len(left) == n_before:
            return left
        size = max(1, size // 2)
