"""How many samples are valid, drawn for all ticks and sensors at once."""

from dataclasses import replace

import pytest

from mrsfi_runtime.engine.compiled.layout import sample_table
from mrsfi_runtime.kernel.flight import initial_state, sample_chances, valid_samples
from mrsfi_runtime.kernel.randomness import PURPOSE_SAMPLES, draw
from mrsfi_runtime.model.mission import Robot, Sensor
from tests.support.world import mission, robot


def carrier(*rates: int) -> Robot:
    """Return a robot with a sensor for each number of samples a tick."""
    sensors = tuple(Sensor(f"s{n}", "s", "DEPTH", 1.0, rate) for n, rate in enumerate(rates))
    return replace(robot("a", 0.0, 0.0), sensors=sensors)


@pytest.mark.parametrize("seed", [0, 1, 2**31, 2**32 - 1, 2**70])
def test_every_number_is_that_of_the_bounds_that_a_draw_of_its_own_is_not_below(seed):
    rates = (1, 2, 5, 1000)
    state = initial_state(mission(robots=(carrier(*rates),), duration=300), seed)

    found = [list(row) for row in valid_samples(state)]

    key = state.mission.seed
    assert found == sample_table(state).tolist()
    assert found == [
        [
            sum(draw(key, tick, k, PURPOSE_SAMPLES) >= bound for bound in sample_chances(rate))
            for k, rate in enumerate(rates)
        ]
        for tick in range(300)
    ]


def test_no_flight_changes_the_samples_of_those_after_it():
    with pytest.raises(ValueError, match="read-only"):
        sample_table(initial_state(mission(), 1))[0, 0] = 7


def test_a_mission_may_do_without_sensors():
    without = initial_state(mission(robots=(carrier(),)), 1)

    assert valid_samples(without) == (b"",) * 100
    assert sample_table(without).shape == (100, 0)


def test_chances_are_those_of_the_binomial_with_mean_one():
    for n in (1, 2, 5, 40, 1000):
        bounds = [bound / 2**32 for bound in sample_chances(n)]
        mean = sum(1.0 - bound for bound in bounds)
        assert abs(mean - 1.0) < 1e-8, n
        assert bounds == sorted(bounds)
