import pytest

from mrsfi_runtime.analysis.tables import GenerationFitness, Trend, find_trend
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


@pytest.mark.parametrize("means", [(), (5.0,), (5.0, 5.0, 5.0)])
def test_without_any_change_there_is_no_trend(means):
    trend = trend_of(*means)

    assert trend.slope == 0.0
    assert trend.intercept == (means[0] if means else 0.0)
