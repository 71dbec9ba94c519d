"""Estimate how many weaknesses there are, from campaigns that searched with different seeds.

Each campaign is a sample. Sets of faults that few of the samples contain show that others are
contained in none. Samples are not as independent, and sets not as alike, as the estimator assumes;
docs/find-weaknesses.md says where it errs.

References
----------
A. Chao, "Estimating the population size for capture-recapture data with unequal catchability",
Biometrics 43, 1987: the estimator Chao2, and its log-normal interval. R. K. Colwell, "EstimateS",
user's guide, appendix B: its form corrected for bias, and the interval if no set is missing.
"""

import math
from collections import Counter
from collections.abc import Collection, Hashable, Iterable, Sequence, Set
from itertools import chain
from typing import Any, NamedTuple, Self

from mrsfi_runtime.causes.weakness import MEASURES, FaultSet, Weakness

_Z = 1.96  # standard deviations on both sides of 95 % of a normal distribution


class Total(NamedTuple):
    """How many sets samples contain, an estimate of how many there are, and its 95 % interval."""

    n_found: int
    value: float
    low: int
    high: int

    @classmethod
    def of(cls, samples: Sequence[Set[Hashable]]) -> Self:
        """Estimate it from at least two samples."""
        n_times = Counter(chain.from_iterable(samples))
        found, by_times = len(n_times), Counter(n_times.values())
        once, twice = by_times[1], by_times[2] + 1
        part = (len(samples) - 1) / len(samples)
        missing = part * once * (once - 1) / (2 * twice)
        if missing:
            variance = missing + part**2 * once * (
                (2 * once - 1) ** 2 / (4 * twice**2)
                + once * (twice - 1) * (once - 1) ** 2 / (4 * twice**4)
            )
            off = math.exp(_Z * math.sqrt(math.log1p(variance / missing**2)))
            low, high = found + missing / off, found + missing * off
        else:
            unseen = math.exp(-n_times.total() / found) if found else 0.0
            middle, off = found / (1 - unseen), _Z * math.sqrt(found * unseen) / (1 - unseen)
            low, high = max(found, middle - off), middle + off
        return cls(found, found + missing, math.floor(low), math.ceil(high))


class Estimate(NamedTuple):
    """The number of weaknesses of a goal by some measures, and those that the first sample lacks.

    ``lacking`` are sets of sorted fault IDs, small ones first.
    """

    n_campaigns: int
    total: Total
    lacking: tuple[tuple[str, ...], ...]

    def as_json(self) -> dict[str, Any]:
        """Return it as plain values."""
        n_found, value, *interval = self.total
        counts = {"campaigns": self.n_campaigns, "found": n_found, "estimated": value}
        return counts | {"interval": interval, "lacking": [*map(list, self.lacking)]}


def estimate(
    campaigns: Sequence[Iterable[Weakness]], goal: str, measures: Collection[str] = MEASURES
) -> Estimate:
    """Estimate the number of weaknesses of a goal from those that each campaign found.

    A set does not count if another campaign found a part of it that breaks the goal by the same
    measure.
    """
    found = [
        {
            (each.column.kind, frozenset(each.faults))
            for each in some
            if each.column.goal == goal and each.column.kind in measures
        }
        for some in campaigns
    ]
    every = set[tuple[str, FaultSet]]().union(*found)
    minimal = {
        (kind, faults)
        for kind, faults in every
        if not any(kind == other and part < faults for other, part in every)
    }
    samples = [{faults for _, faults in some & minimal} for some in found]
    lacking = (tuple(sorted(each)) for each in set[FaultSet]().union(*samples) - samples[0])
    ordered = sorted(lacking, key=lambda faults: (len(faults), faults))
    return Estimate(len(samples), Total.of(samples), tuple(ordered))
