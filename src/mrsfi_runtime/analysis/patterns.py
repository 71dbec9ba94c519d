"""Which fault types occur in the most critical specifications, beside their base share.

A type that search met often is popular, not guilty: a count says something only beside the
count that the type would have if the top were a random draw from the pool, and beside its
share in everything the campaign tried.

References
----------
Source paper, section V, RQ2 and figure 12.
"""

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from mrsfi_runtime.model.faults import FaultPool, Specification


@dataclass(frozen=True, slots=True)
class TypePattern:
    """How often one fault type occurs in the top specifications.

    Attributes
    ----------
    n_occurrences
        Timed faults of the type in the top specifications.
    n_specifications
        Top specifications that contain it.
    share
        Of the top specifications' timed faults, in [0, 1].
    pool_share, campaign_share
        Of the pool's faults, and of the timed faults of all specifications, in [0, 1].
    pool_expected, campaign_expected
        Occurrences that the top would have if its shares were those.
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
    top: Sequence[Specification], campaign: Iterable[Specification], pool: FaultPool
) -> tuple[TypePattern, ...]:
    """Count every fault type of the pool, most occurrences first, then by name."""
    in_top = _occurrences(top, pool)
    in_campaign = _occurrences(campaign, pool)
    in_pool = Counter(fault.type for fault in pool)
    containing = Counter(
        kind
        for specification in top
        for kind in {pool[timed.fault].type for timed in specification}
    )
    n_top = in_top.total()
    patterns = [
        TypePattern(
            type=kind,
            n_occurrences=in_top[kind],
            n_specifications=containing[kind],
            share=_share(in_top, kind),
            pool_share=_share(in_pool, kind),
            campaign_share=_share(in_campaign, kind),
            pool_expected=n_top * _share(in_pool, kind),
            campaign_expected=n_top * _share(in_campaign, kind),
        )
        for kind in in_pool
    ]
    return tuple(sorted(patterns, key=lambda pattern: (-pattern.n_occurrences, pattern.type)))


def _occurrences(specifications: Iterable[Specification], pool: FaultPool) -> Counter[str]:
    return Counter(
        pool[timed.fault].type for specification in specifications for timed in specification
    )


def _share(counts: Counter[str], kind: str) -> float:
    total = counts.total()
    return counts[kind] / total if total else 0.0
