"""Fitness from generation to generation, and whether it grows.

References
----------
Source paper, section V, RQ1 and figures 6 to 9. M. G. Kendall, "A New Measure of Rank
Correlation", Biometrika 30, 1938; H. B. Mann, "Nonparametric Tests Against Trend",
Econometrica 13, 1945.
"""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from math import erfc, fsum, sqrt

from mrsfi_runtime.record.campaign import Generation


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
    """Fitness over the generations, and whether its mean goes up.

    Attributes
    ----------
    slope, intercept
        Least-squares line through the means: fitness per generation, and at generation 0.
    tau
        Kendall's tau-b between generation and mean, in [-1, 1]; 0 if all means are equal.
    p_value
        Two-sided, of no trend; 1 with fewer than two generations or all means equal.
    """

    generations: tuple[GenerationFitness, ...]
    slope: float
    intercept: float
    tau: float
    p_value: float


def find_trend(generations: Sequence[Generation]) -> Trend:
    """Return the fitness of each generation and the trend of the means.

    Notes
    -----
    The p-value takes Kendall's S as normally distributed, with the correction for ties and
    for continuity (the Mann-Kendall test). That is rough below some ten generations, and
    generations of one search are not independent: read it as a description, not a proof.
    """
    rows = tuple(
        GenerationFitness(
            generation.index,
            generation.statistics["mean"],
            generation.statistics["std"],
            generation.statistics["max"],
            generation.statistics["min"],
        )
        for generation in generations
    )
    means = [row.mean for row in rows]
    slope, intercept = _line([float(row.generation) for row in rows], means)
    tau, p_value = _kendall(means)
    return Trend(rows, slope, intercept, tau, p_value)


def _line(xs: Sequence[float], ys: Sequence[float]) -> tuple[float, float]:
    """Return slope and intercept of the least-squares line; flat if there is none."""
    if not xs:
        return 0.0, 0.0
    x_mean, y_mean = fsum(xs) / len(xs), fsum(ys) / len(ys)
    spread = fsum((x - x_mean) * (x - x_mean) for x in xs)
    if spread == 0:
        return 0.0, y_mean
    slope = fsum((x - x_mean) * (y - y_mean) for x, y in zip(xs, ys, strict=True)) / spread
    return slope, y_mean - slope * x_mean


def _kendall(values: Sequence[float]) -> tuple[float, float]:
    """Return tau-b of values against their place, and its two-sided p-value."""
    n = len(values)
    s = sum(
        (later > earlier) - (later < earlier)
        for i, earlier in enumerate(values)
        for later in values[i + 1 :]
    )
    ties = Counter(values).values()
    n_pairs = n * (n - 1) // 2
    n_untied = n_pairs - sum(t * (t - 1) // 2 for t in ties)
    if n_untied == 0:
        return 0.0, 1.0
    variance = (n * (n - 1) * (2 * n + 5) - sum(t * (t - 1) * (2 * t + 5) for t in ties)) / 18
    z = max(abs(s) - 1, 0) / sqrt(variance)
    return s / sqrt(n_pairs * n_untied), erfc(z / sqrt(2))
