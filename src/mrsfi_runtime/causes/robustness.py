"""Whether a cause set breaks goals with other mission seeds too, or only by chance with its own."""

from collections.abc import Sequence
from dataclasses import dataclass
from statistics import median

from mrsfi_runtime.causes.counts import Counts

N_SEEDS = 20
"""Mission seeds in which a cause set is flown, from its own on."""


@dataclass(frozen=True, slots=True)
class Robustness:
    """What a count is in several mission seeds, and in how many of them above 0."""

    median: float
    least: int
    most: int
    n_violated: int


def robustness(by_seed: Sequence[Counts]) -> tuple[Robustness, ...]:
    """Return what each count is over mission seeds, one entry a column."""
    return tuple(
        Robustness(median(counts), min(counts), max(counts), sum(map(bool, counts)))
        for counts in zip(*by_seed, strict=True)
    )
