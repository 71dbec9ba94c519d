from math import ceil

import pytest

from tests.support.cluster import require_dask

require_dask()

from mrsfi_runtime.engine.cluster import CHUNK_SECONDS, Pace  # noqa: E402 - needs dask


def test_every_worker_gets_a_chunk_while_there_are_enough_specifications():
    pace = Pace()
    pace.learn(100, 0.001)

    for n_specifications in (1, 7, 20, 900):
        for n_workers in (1, 2, 3, 8):
            size = pace.chunk_size(n_specifications, n_workers)
            assert ceil(n_specifications / size) >= min(n_specifications, n_workers) - 1
            assert size == ceil(n_specifications / n_workers)


@pytest.mark.parametrize("seconds", [0.0003, 0.025, 0.1])
def test_a_chunk_takes_as_long_as_it_should_once_the_pace_is_known(seconds):
    pace = Pace()

    for _ in range(20):
        size = pace.chunk_size(10_000, 2)
        pace.learn(size, size * seconds)

    assert 0.7 * CHUNK_SECONDS < pace.chunk_size(10_000, 2) * seconds <= CHUNK_SECONDS


def test_an_evaluation_that_takes_longer_than_a_chunk_should_goes_alone():
    pace = Pace()
    pace.learn(1, 10.0)

    assert pace.chunk_size(20, 2) == 1


def test_evaluations_too_fast_for_the_clock_are_no_division_by_zero():
    pace = Pace()
    pace.learn(4, 0.0)

    assert pace.chunk_size(100, 2) == 50


def test_the_pace_follows_a_mission_that_slows_down():
    pace = Pace()
    pace.learn(10, 0.01)
    fast = pace.chunk_size(10_000, 1)

    for _ in range(10):
        pace.learn(10, 1.0)

    assert pace.chunk_size(10_000, 1) < fast / 50
