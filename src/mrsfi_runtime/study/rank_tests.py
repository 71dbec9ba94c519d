"""Statistics of two samples by rank: no assumption on how results of a search are distributed.

References
----------
H. B. Mann and D. R. Whitney, "On a Test of Whether one of Two Random Variables is
Stochastically Larger than the Other", Annals of Mathematical Statistics 18, 1947; A. Vargha and
H. D. Delaney, "A Critique and Improvement of the CL Common Language Effect Size Statistics of
McGraw and Wong", Journal of Educational and Behavioral Statistics 25, 2000; S. Holm, "A Simple
Sequentially Rejective Multiple Test Procedure", Scandinavian Journal of Statistics 6, 1979.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import comb

from scipy.stats import PermutationMethod, mannwhitneyu

_MOST_EXACT = 20_000  # divisions of the pooled values that are enumerated to be exact
_MAGNITUDES = ((0.71, "large"), (0.64, "medium"), (0.56, "small"))


@dataclass(frozen=True, slots=True)
class Quartiles:
    """Quartiles of a sample; infinite where it reaches infinity."""

    lower: float
    median: float
    upper: float


@dataclass(frozen=True, slots=True)
class RankTest:
    """How two samples compare.

    Attributes
    ----------
    u
        Mann-Whitney U of the first sample: pairs in which its value is the larger one, ties half.
    p_value
        Two-sided, of both samples having one distribution.
    method
        ``exact`` over all divisions of the pooled values, or ``normal``, with the corrections
        for ties and continuity.
    a12
        Chance that a value of the first sample is larger than one of the second, ties half.
    """

    u: float
    p_value: float
    method: str
    a12: float

    @property
    def magnitude(self) -> str:
        """Size of the effect in the words of Vargha and Delaney."""
        distance = max(self.a12, 1.0 - self.a12)
        return next((word for least, word in _MAGNITUDES if distance >= least), "negligible")


def quartiles(values: Sequence[float]) -> Quartiles:
    """Return the quartiles of at least one value, between neighbours by straight line."""
    ordered = sorted(values)
    return Quartiles(*(_quantile(ordered, share) for share in (0.25, 0.5, 0.75)))


def _quantile(ordered: Sequence[float], share: float) -> float:
    place = share * (len(ordered) - 1)
    below = int(place)
    rest = place - below
    if rest == 0.0 or ordered[below] == ordered[below + 1]:
        return ordered[below]
    return ordered[below] + rest * (ordered[below + 1] - ordered[below])


def compare_ranks(first: Sequence[float], second: Sequence[float]) -> RankTest:
    """Compare two samples of at least one value each; infinite values are ranked, too.

    Notes
    -----
    Exact where at most 20,000 divisions of the pooled values into two such samples have to be
    enumerated (8 against 8), ties or not; beyond, and for a sample of one value, the normal
    approximation.
    """
    n_pairs = len(first) * len(second)
    if len({*first, *second}) == 1:
        return RankTest(n_pairs / 2, 1.0, "exact", 0.5)
    n_divisions = comb(len(first) + len(second), len(first))
    is_exact = n_divisions <= _MOST_EXACT and min(len(first), len(second)) > 1
    method = PermutationMethod(n_resamples=_MOST_EXACT) if is_exact else "asymptotic"
    found = mannwhitneyu(first, second, method=method)
    u = float(found.statistic)
    return RankTest(u, float(found.pvalue), "exact" if is_exact else "normal", u / n_pairs)


def holm(p_values: Sequence[float]) -> tuple[float, ...]:
    """Return p-values adjusted for being several, in the given order."""
    adjusted = [0.0] * len(p_values)
    largest = 0.0
    by_size = sorted(range(len(p_values)), key=p_values.__getitem__)
    for n_before, place in enumerate(by_size):
        largest = max(largest, min(1.0, (len(p_values) - n_before) * p_values[place]))
        adjusted[place] = largest
    return tuple(adjusted)
