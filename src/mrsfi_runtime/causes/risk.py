"""How likely faults are to break a goal, from their likelihoods and the weaknesses found.

Faults occur independently of each other. If all faults of a minimal set occur, they break the goal
with the share of their variants, independently of other sets. ``Risk`` has a lower value, for which
only what is known counts, and an upper one, for which what is estimated counts, too.

References
----------
C. J. Clopper and E. S. Pearson, "The use of confidence or fiducial limits illustrated in the case
of the binomial", Biometrika 26, 1934: the lower end of a share.
"""

import math
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from itertools import chain
from typing import NamedTuple, TypeAlias

from mrsfi_runtime.causes.mildest import GoalWeakness
from mrsfi_runtime.causes.missing import estimate
from mrsfi_runtime.causes.weakness import MEASURES, FaultSet, Weakness
from mrsfi_runtime.model.faults import FaultPool

Share: TypeAlias = tuple[FaultSet, float]
"""A set of faults, and the chance that it breaks a goal if its faults occur."""

_TAIL = 0.025  # of a distribution, beyond one end of a 95 % interval
_MOST_PIVOTS = 12  # faults on whose occurrence a tree is split; time doubles with each


class Risk(NamedTuple):
    """How likely a goal is to be truly violated or to fail in a mission, 0 … 1.

    ``upper`` is ``None`` without campaigns to estimate from. ``n_sets`` minimal sets are known,
    ``n_unknown`` of which have a fault without likelihood and do not count for ``lower``.
    """

    lower: float
    upper: float | None
    n_sets: int
    n_unknown: int


def cut_sets(weaknesses: Iterable[GoalWeakness], goal: str) -> list[tuple[str, ...]]:
    """Return the minimal sets of faults that truly violate a goal or make it fail, by size."""
    breaking = (each for each in weaknesses if each.goal == goal)
    real = {each.faults for each in breaking if each.shown.column.kind != MEASURES[0]}
    least = (faults for faults in real if not any({*other} < {*faults} for other in real))
    return sorted(least, key=lambda faults: (len(faults), faults))


def occurrence(pool: FaultPool, faults: Iterable[str]) -> float | None:
    """Return how likely all of some faults are to occur; ``None`` if a likelihood is unknown."""
    chances = [pool[fault].likelihood for fault in faults]
    known = [chance for chance in chances if chance is not None]
    return math.prod(known) if len(known) == len(chances) else None


def risk(pool: FaultPool, goal: str, campaigns: Sequence[Sequence[GoalWeakness]]) -> Risk | None:
    """Return the risk of a goal by what campaigns found; ``None`` if no likelihood is known.

    The lower value takes the lower ends of shares. For the upper one, every variant breaks the
    goal, sets are independent, and there are as many as the upper end of the estimate says: those
    of unknown likelihood, and those not found, are as likely as the mean of the others.
    """
    every = [each for some in campaigns for each in some if each.goal == goal]
    shares = dict[FaultSet, float]()
    for faults in cut_sets(every, goal):
        by = (one for each in every if each.faults == faults for one in each.by)
        truly = (one for one in by if one.column.kind != MEASURES[0])
        shares[frozenset(faults)] = max(map(_least_share, truly))
    chances = {faults: occurrence(pool, faults) for faults in shares}
    known = {faults: chance for faults, chance in chances.items() if chance is not None}
    if not known:
        return None
    likelihoods = {fault.id: fault.likelihood or 0.0 for fault in pool}
    lower = 1.0 - kept([(faults, shares[faults]) for faults in known], likelihoods)
    upper = None
    if len(campaigns) > 1:
        found = [[one for each in some for one in each.by] for some in campaigns]
        n_others = max(len(shares), estimate(found, goal, MEASURES[1:]).total.high) - len(known)
        mean = math.fsum(known.values()) / len(known)
        upper = 1.0 - math.prod(1.0 - each for each in known.values()) * (1.0 - mean) ** n_others
    return Risk(lower, upper, len(shares), len(shares) - len(known))


def risks(
    pool: FaultPool, goals: Iterable[str], campaigns: Sequence[Sequence[GoalWeakness]]
) -> dict[str, Risk]:
    """Return the risk of each of some goals, without those for which no likelihood is known."""
    found = {goal: risk(pool, goal, campaigns) for goal in goals}
    return {goal: each for goal, each in found.items() if each}


def _least_share(weakness: Weakness) -> float:
    """Return the lower end of a weakness's share (of several faults, Clopper and Pearson's).

    The variants of several faults were chosen by the search, which favours those that break.
    """
    if weakness.weighted is not None:
        return weakness.weighted.low
    n, low, high = weakness.n_tried, 0.0, 1.0
    while high - low > 1e-6:
        share = (low + high) / 2
        ways = (
            math.comb(n, k) * share**k * (1 - share) ** (n - k)
            for k in range(weakness.n_broken, n + 1)
        )
        low, high = (share, high) if math.fsum(ways) < _TAIL else (low, share)
    return low


def kept(
    sets: Sequence[Share], likelihoods: Mapping[str, float], n_pivots: int = _MOST_PIVOTS
) -> float:
    """Return the chance that no set breaks the goal, by a fault that several sets have.

    If many sets share faults, it is an upper bound.
    """

    def chance(each: Share) -> float:
        return each[1] * math.prod(likelihoods[fault] for fault in each[0])

    n_times = Counter(chain.from_iterable(faults for faults, _ in sets))
    fault, n_most = max(n_times.items(), key=lambda each: (each[1], each[0]), default=("", 0))
    if n_most > 1 and n_pivots:
        likelihood = likelihoods[fault]
        occurs = [(faults - {fault}, share) for faults, share in sets]
        absent = [each for each in sets if fault not in each[0]]
        with_it, without = (kept(some, likelihoods, n_pivots - 1) for some in (occurs, absent))
        return likelihood * with_it + (1.0 - likelihood) * without
    taken: set[str] = set()
    none = 1.0
    for each in sorted(sets, key=chance, reverse=True):
        if taken.isdisjoint(each[0]):  # sets without a common fault are independent
            taken |= each[0]
            none *= 1.0 - chance(each)
    return none
