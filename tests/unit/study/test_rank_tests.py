from itertools import combinations
from math import erfc, inf, sqrt

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mrsfi_runtime.study.comparison import Quartiles, RankTest, compare_ranks, holm, quartiles

FEW = st.lists(st.integers(0, 4), min_size=2, max_size=5)


def wins(first: list[float], second: list[float]) -> float:
    return sum((a > b) + 0.5 * (a == b) for a in first for b in second)


def every_u(pooled: list[float], n_first: int) -> list[float]:
    """Return U of every division of the pooled values."""
    found = []
    for chosen in combinations(range(len(pooled)), n_first):
        first = [pooled[i] for i in chosen]
        second = [value for i, value in enumerate(pooled) if i not in chosen]
        found.append(wins(first, second))
    return found


@given(FEW, FEW)
def test_small_samples_have_the_p_value_of_all_divisions_ties_or_not(first, second):
    u = wins(first, second)
    all_u = every_u([*first, *second], len(first))
    n_least = min(sum(v <= u for v in all_u), sum(v >= u for v in all_u))

    found = compare_ranks(first, second)

    assert (found.u, found.method) == (u, "exact")
    assert found.a12 == pytest.approx(u / (len(first) * len(second)))
    assert found.p_value == pytest.approx(min(1.0, 2 * n_least / len(all_u)))


def test_the_textbook_case_without_ties():
    # Age at diagnosis of five men and four women; U = 17 and p = 0.1111 in the literature.
    men, women = [19, 22, 16, 29, 24], [20, 11, 17, 12]

    found = compare_ranks(men, women)

    assert (found.u, found.method, found.a12) == (17.0, "exact", 0.85)
    assert found.p_value == pytest.approx(14 / 126)
    assert found.magnitude == "large"


def test_a_sample_of_one_value_is_not_told_from_another():
    found = compare_ranks([1.0], [2.0])

    assert (found.u, found.a12) == (0.0, 0.0)
    assert found.p_value > 0.9


@pytest.mark.parametrize("n", [1, 4, 30])
def test_samples_in_which_all_values_are_equal_do_not_differ(n):
    assert compare_ranks([3.0] * n, [3.0] * n) == RankTest(n * n / 2, 1.0, "exact", 0.5)


def test_large_samples_have_the_normal_p_value_with_corrections():
    first = [value % 7 for value in range(30)]
    second = [value % 5 + 1 for value in range(30)]
    _, ties = np.unique([*first, *second], return_counts=True)
    variance = 900 / 12 * (61 - sum(t**3 - t for t in ties) / (60 * 59))
    u = wins(first, second)
    z = (abs(u - 450) - 0.5) / sqrt(variance)

    found = compare_ranks(first, second)

    assert (found.u, found.method) == (u, "normal")
    assert found.p_value == pytest.approx(erfc(z / sqrt(2)))


def test_what_was_never_reached_is_ranked_behind_everything():
    few = compare_ranks([1.0, 2.0, inf], [3.0, inf, inf])
    many = compare_ranks([5.0] * 15 + [inf] * 15, [7.0] * 5 + [inf] * 25)

    assert few == compare_ranks([1.0, 2.0, 4.0], [3.0, 4.0, 4.0])
    assert many == compare_ranks([5] * 15 + [9] * 15, [7] * 5 + [9] * 25)
    assert compare_ranks([-inf, -inf], [-inf]).p_value == 1.0


@pytest.mark.parametrize("n", [1, 3, 40])
def test_samples_of_one_value_do_not_differ(n):
    found = compare_ranks([2.0] * n, [2.0] * n)

    assert (found.u, found.p_value, found.a12, found.magnitude) == (
        n * n / 2,
        1.0,
        0.5,
        "negligible",
    )


@pytest.mark.parametrize(
    ("a12", "magnitude"),
    [
        (0.5, "negligible"),
        (0.559, "negligible"),
        (0.56, "small"),
        (0.639, "small"),
        (0.64, "medium"),
        (0.709, "medium"),
        (0.71, "large"),
        (0.0, "large"),
        (0.4, "small"),
    ],
)
def test_magnitude_has_the_thresholds_of_vargha_and_delaney(a12, magnitude):
    assert RankTest(0.0, 1.0, "exact", a12).magnitude == magnitude


def test_holm_adjusts_as_in_the_literature():
    # R: p.adjust(c(0.01, 0.04, 0.03, 0.005), "holm")
    assert holm([0.01, 0.04, 0.03, 0.005]) == pytest.approx((0.03, 0.06, 0.06, 0.02))
    assert holm([0.6, 0.5]) == (1.0, 1.0)
    assert holm([0.04]) == (0.04,)
    assert holm([]) == ()


@given(st.lists(st.floats(0, 1), max_size=8))
def test_holm_keeps_the_order_and_lowers_no_p_value(p_values):
    adjusted = holm(p_values)

    assert all(p <= a <= 1.0 for p, a in zip(p_values, adjusted, strict=True))
    by_p = sorted(range(len(p_values)), key=p_values.__getitem__)
    assert sorted(adjusted) == [adjusted[place] for place in by_p]


@given(st.lists(st.integers(-50, 50), min_size=1, max_size=12))
def test_quartiles_are_those_of_numpy(values):
    found = quartiles([float(value) for value in values])

    expected = np.quantile(values, [0.25, 0.5, 0.75])
    assert (found.lower, found.median, found.upper) == pytest.approx(tuple(expected))


def test_quartiles_of_what_was_never_reached_are_infinite():
    assert quartiles([3.0, inf, 1.0, 2.0]) == Quartiles(1.75, 2.5, inf)
    assert quartiles([inf, 1.0]) == Quartiles(inf, inf, inf)
    assert quartiles([inf, inf, 1.0, 1.0, 1.0]) == Quartiles(1.0, 1.0, inf)
