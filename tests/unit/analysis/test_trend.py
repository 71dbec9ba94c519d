from itertools import combinations
from math import sqrt

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mrsfi_runtime.analysis.patterns import GenerationFitness, Trend, find_trend
from mrsfi_runtime.record.store import Generation


def trend_of(*means: float) -> Trend:
    return find_trend(
        [
            Generation(i, {"mean": m, "std": 1.0, "min": m - 1, "max": m + 2}, (), "[]")
            for i, m in enumerate(means)
        ]
    )


def test_each_generation_keeps_its_numbers():
    assert trend_of(4.0, 6.0).generations == (
        GenerationFitness(generation=0, mean=4.0, std=1.0, best=6.0, worst=3.0),
        GenerationFitness(generation=1, mean=6.0, std=1.0, best=8.0, worst=5.0),
    )


def test_a_line_is_found_again():
    trend = trend_of(*(3.0 + 0.5 * x for x in range(12)))

    assert trend.slope == pytest.approx(0.5)
    assert trend.intercept == pytest.approx(3.0)
    assert trend.tau == 1.0


@given(st.lists(st.integers(0, 5), max_size=12))
def test_tau_is_positive_where_more_pairs_rise_than_fall(means):
    pairs = list(combinations(means, 2))
    n_rising = sum(later > earlier for earlier, later in pairs)
    n_falling = sum(later < earlier for earlier, later in pairs)

    tau = trend_of(*map(float, means)).tau

    untied = n_rising + n_falling
    assert tau == (
        0.0 if not untied else pytest.approx((n_rising - n_falling) / sqrt(len(pairs) * untied))
    )


def test_ties_are_corrected_as_in_the_literature():
    """As ``scipy.stats.kendalltau`` has it."""
    assert trend_of(1, 2, 2, 3, 5, 3).tau == pytest.approx(0.7877264, abs=1e-6)


@pytest.mark.parametrize("means", [(), (5.0,), (5.0, 5.0, 5.0)])
def test_without_any_change_there_is_no_trend(means):
    trend = trend_of(*means)

    assert (trend.slope, trend.tau) == (0.0, 0.0)
    assert trend.intercept == (means[0] if means else 0.0)
