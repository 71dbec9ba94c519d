"""What repeats in a campaign: fitness over its generations, fault types among its worst.

A type that search met often is popular, not guilty: a count says something only beside the
count that the type would have if the top were a random draw from the pool, and beside its
share in everything the campaign tried.

References
----------
Source paper, section V, RQ1, RQ2 and figures 6 to 9 and 12.
"""

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from operator import itemgetter
from statistics import linear_regression

from mrsfi_runtime.model.faults import FaultPool, Specification
from mrsfi_runtime.record.store import Generation


@dataclass(frozen=True, slots=True)
class GenerationFitness:
    """Fitness of one generation's population."""

    generation: int
    mean: float
    std: float
    best: float
    worst: float


@dataclass(frozen=True, slots=True)
class Trend:
    """Fitness over the generations, and the line of least squares through their means.

    It describes one run. There is no p-value, because generations of one search depend on each
    other; whether an algorithm does better is tested over many seeds (``study.comparison``).
    """

    generations: tuple[GenerationFitness, ...]
    slope: float
    intercept: float


def find_trend(generations: Iterable[Generation]) -> Trend:
    """Return the fitness of each generation and the trend of the means."""
    of = itemgetter("mean", "std", "max", "min")
    rows = tuple(GenerationFitness(each.index, *of(each.statistics)) for each in generations)
    means = [row.mean for row in rows]
    slope, intercept = 0.0, sum(means, 0.0)
    if len(rows) > 1:
        slope, intercept = linear_regression([float(row.generation) for row in rows], means)
    return Trend(rows, slope, intercept)


@dataclass(frozen=True, slots=True)
class TypePattern:
    """How often one fault type occurs in the top: timed faults, and specifications with one.

    ``share`` is of the top's timed faults, ``pool_share`` of the pool's faults, ``campaign_share``
    of all specifications' timed faults, each in [0, 1]; the top would have as many as
    ``…_expected`` if its shares were those.
    """

    type: str
    n_occurrences: int
    n_specifications: int
    share: float
    pool_share: float
    campaign_share: float
    pool_expected: float
    campaign_expected: float


def find_patterns(
    top: Sequence[Specification], tried: Mapping[str, int], pool: FaultPool
) -> tuple[TypePattern, ...]:
    """Count every fault type of the pool in the top, most occurrences first, then by name.

    ``tried`` says how often each fault, by its ID, stands in the campaign's specifications.
    """
    in_top = _types(Counter(timed.fault for each in top for timed in each), pool)
    in_campaign = _types(tried, pool)
    in_pool = Counter(fault.type for fault in pool)
    containing = Counter(
        kind
        for specification in top
        for kind in {pool[timed.fault].type for timed in specification}
    )
    n_top = in_top.total()
    patterns = []
    for kind in in_pool:
        shares = [_share(counts, kind) for counts in (in_top, in_pool, in_campaign)]
        expected = [n_top * share for share in shares[1:]]
        patterns.append(TypePattern(kind, in_top[kind], containing[kind], *shares, *expected))
    return tuple(sorted(patterns, key=lambda pattern: (-pattern.n_occurrences, pattern.type)))


def _types(faults: Mapping[str, int], pool: FaultPool) -> Counter[str]:
    types: Counter[str] = Counter()
    for fault, n_occurrences in faults.items():
        types[pool[fault].type] += n_occurrences
    return types


def _share(counts: Counter[str], kind: str) -> float:
    total = counts.total()
    return counts[kind] / total if total else 0.0
