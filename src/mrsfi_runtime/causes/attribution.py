"""How much of each count is due to each fault of a set: Shapley values.

References
----------
L. S. Shapley, "A Value for n-Person Games", Annals of Mathematics Studies 28, 1953. J. Castro,
D. Gómez and J. Tejada, "Polynomial Calculation of the Shapley Value Based on Sampling", Computers
and Operations Research 36, 2009.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import combinations
from operator import sub
from random import Random
from statistics import stdev

from mrsfi_runtime.causes.cause_set import chosen
from mrsfi_runtime.causes.counts import Counts, Flights
from mrsfi_runtime.model.faults import Specification

N_EXACT = 10
"""Faults up to which every subset is flown: 1,024 of them."""

N_PERMUTATIONS = 100
"""Orders in which faults join where there are more."""

_SEED = 1
_NORMAL = 1.96  # of a normal distribution, 95 % lies so many standard deviations from the mean


@dataclass(frozen=True, slots=True)
class Attribution:
    """Shares of faults in counts, in ticks, shape ``(n_faults, n_columns)``.

    Each column of ``shares`` sums to what the faults together add to the count without faults.
    ``margins`` are half of the 95 % confidence intervals; ``None`` if shares are exact.
    """

    shares: tuple[tuple[Fraction, ...], ...]
    margins: tuple[tuple[float, ...], ...] | None


def attribute(flights: Flights, specification: Specification) -> Attribution:
    """Return how much of each count is due to each fault of a specification.

    A share is the mean of what the fault adds when it joins those before it, over all orders in
    which the faults can join; beyond ``N_EXACT`` faults over ``N_PERMUTATIONS`` drawn ones, the
    same in every call.
    """
    if len(specification) <= N_EXACT:
        return Attribution(_exact(flights, specification), None)
    return _sampled(flights, specification)


def _exact(flights: Flights, specification: Specification) -> tuple[tuple[Fraction, ...], ...]:
    n = len(specification)
    everyone = range(n)
    flights.fly(
        chosen(specification, places)
        for size in range(n + 1)
        for places in combinations(everyone, size)
    )
    orders = math.factorial(n)
    shares = []
    for joining in everyone:
        others = [place for place in everyone if place != joining]
        added = []
        for size in range(n):
            weight = math.factorial(size) * math.factorial(n - size - 1)
            for before in combinations(others, size):
                more = _added(flights, specification, before, joining)
                added.append([weight * each for each in more])
        shares.append(tuple(Fraction(sum(each), orders) for each in zip(*added, strict=True)))
    return tuple(shares)


def _added(
    flights: Flights, specification: Specification, before: Sequence[int], joining: int
) -> Counts:
    """Return what a fault adds to each count when it joins some others, all by their places."""
    less, more = (chosen(specification, places) for places in (before, (*before, joining)))
    return tuple(map(sub, flights.counts(more), flights.counts(less)))


def _sampled(flights: Flights, specification: Specification) -> Attribution:
    random = Random(_SEED)
    everyone = range(len(specification))
    orders = [random.sample(everyone, len(everyone)) for _ in range(N_PERMUTATIONS)]
    flights.fly(
        chosen(specification, order[:size]) for order in orders for size in range(len(order) + 1)
    )
    added: list[list[Counts]] = [[] for _ in everyone]
    for order in orders:
        for n_before, joining in enumerate(order):
            added[joining].append(_added(flights, specification, order[:n_before], joining))
    columns = [tuple(zip(*of_fault, strict=True)) for of_fault in added]
    scale = _NORMAL / math.sqrt(N_PERMUTATIONS)
    return Attribution(
        tuple(
            tuple(Fraction(sum(column), N_PERMUTATIONS) for column in of_fault)
            for of_fault in columns
        ),
        tuple(tuple(scale * stdev(column) for column in of_fault) for of_fault in columns),
    )
