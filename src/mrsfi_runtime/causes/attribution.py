"""How much of each count is due to each fault of a set: Shapley values.

References
----------
L. S. Shapley, "A Value for n-Person Games", Annals of Mathematics Studies 28, 1953. J. Castro,
D. Gómez and J. Tejada, "Polynomial Calculation of the Shapley Value Based on Sampling", Computers
and Operations Research 36, 2009.
"""

import math
from dataclasses import dataclass
from fractions import Fraction
from itertools import combinations
from random import Random
from statistics import stdev
from typing import TypeAlias

from mrsfi_runtime.causes.cause_set import without
from mrsfi_runtime.causes.counts import Counts, Flights
from mrsfi_runtime.model.faults import Specification, TimedFault

N_EXACT = 10
"""Faults up to which every subset is flown: 1,024 of them."""

N_PERMUTATIONS = 100
"""Orders in which faults join where there are more."""

_SEED = 1
_NORMAL = 1.96  # of a normal distribution, 95 % lies so many standard deviations from the mean

Shares: TypeAlias = tuple[tuple[Fraction, ...], ...]
"""Shape ``(n_faults, n_columns)``."""


@dataclass(frozen=True, slots=True)
class Attribution:
    """Shares of faults in counts, in ticks.

    Each column of ``shares`` sums to what the faults together add to the count without faults.
    ``margins`` are half of the 95 % confidence intervals; ``None`` if shares are exact.
    """

    shares: Shares
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


def _exact(flights: Flights, specification: Specification) -> Shares:
    n = len(specification)
    flights.fly(subset for size in range(n + 1) for subset in combinations(specification, size))
    orders = math.factorial(n)
    shares = []
    for place, fault in enumerate(specification):
        others = without(specification, place)
        sums = [0] * len(flights.columns)
        for size in range(n):
            weight = math.factorial(size) * math.factorial(n - size - 1)
            for before in combinations(others, size):
                added = _added(flights, before, _with(specification, before, fault))
                sums = [total + weight * more for total, more in zip(sums, added, strict=True)]
        shares.append(tuple(Fraction(total, orders) for total in sums))
    return tuple(shares)


def _with(specification: Specification, before: Specification, fault: TimedFault) -> Specification:
    joined = {*before, fault}
    return tuple(each for each in specification if each in joined)


def _added(flights: Flights, before: Specification, after: Specification) -> Counts:
    pairs = zip(flights.counts(before), flights.counts(after), strict=True)
    return tuple(more - less for less, more in pairs)


def _sampled(flights: Flights, specification: Specification) -> Attribution:
    random = Random(_SEED)
    orders = [random.sample(specification, len(specification)) for _ in range(N_PERMUTATIONS)]
    chains = [
        [_with_all(specification, order[:size]) for size in range(len(order) + 1)]
        for order in orders
    ]
    flights.fly(each for chain in chains for each in chain)
    added: dict[TimedFault, list[Counts]] = {fault: [] for fault in specification}
    for order, chain in zip(orders, chains, strict=True):
        for fault, before, after in zip(order, chain, chain[1:], strict=False):
            added[fault].append(_added(flights, before, after))
    columns = [tuple(zip(*added[fault], strict=True)) for fault in specification]
    scale = _NORMAL / math.sqrt(N_PERMUTATIONS)
    return Attribution(
        tuple(
            tuple(Fraction(sum(column), N_PERMUTATIONS) for column in of_fault)
            for of_fault in columns
        ),
        tuple(tuple(scale * stdev(column) for column in of_fault) for of_fault in columns),
    )


def _with_all(specification: Specification, joined: list[TimedFault]) -> Specification:
    return tuple(each for each in specification if each in joined)
