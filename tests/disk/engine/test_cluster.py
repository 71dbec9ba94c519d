"""Workers of a cluster: the pace of their chunks, and what is shipped to them."""

import pickle
from dataclasses import replace
from math import ceil
from pathlib import Path

import pytest

from mrsfi_runtime.generated_code import load_code
from tests.support.cluster import require_dask
from tests.support.world import ROOT

require_dask()

from mrsfi_runtime.engine.cluster import CHUNK_SECONDS, Pace, Shipment  # noqa: E402 - needs dask

GENERATED = ROOT / "generated" / "tight_margins"


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


def test_what_is_unpacked_elsewhere_loads_as_the_same_mission(tmp_path):
    shipment = pickle.loads(pickle.dumps(Shipment.of(GENERATED)))

    shipment.unpack(tmp_path / "worker" / "mission")

    found, expected = load_code(tmp_path / "worker" / "mission"), load_code(GENERATED)
    assert (found.mission, found.pool) == (expected.mission, expected.pool)


def test_the_name_follows_from_the_content_alone(tmp_path):
    shipment = Shipment.of(GENERATED)
    shipment.unpack(tmp_path)
    copied = Shipment.of(tmp_path)

    (tmp_path / "mission_loader.py").write_text("other", encoding="utf-8")
    changed = Shipment.of(tmp_path)

    assert copied.name == shipment.name != changed.name


def test_texts_of_a_worker_name_the_places_at_home():
    shipment = replace(Shipment.of(GENERATED), given="generated/x", absolute="/home/me/generated/x")
    text = 'File "/far/away/a.py", line 3\nError: /far/away/a.py:3: wrong'

    told = shipment.with_original_paths(text, Path("/far/away"))

    assert told == 'File "/home/me/generated/x/a.py", line 3\nError: generated/x/a.py:3: wrong'


def test_the_process_that_packed_differs_in_nothing():
    assert Shipment.of(GENERATED).differences() == ""


def test_every_difference_is_named_with_what_was_found_and_expected():
    shipment = Shipment.of(GENERATED)
    packed = replace(
        shipment, environment={**shipment.environment, "Python": "2.7", "numba": "0.1"}
    )

    here = shipment.environment
    assert packed.differences() == (
        f"Python {here['Python']} where this command has 2.7, "
        f"numba {here['numba']} where this command has 0.1"
    )


def test_copies_of_what_the_code_imports_travel_with_it(tmp_path):
    Shipment.of(GENERATED).unpack(tmp_path / "home")
    (tmp_path / "home" / "imported" / "pack").mkdir(parents=True)
    (tmp_path / "home" / "imported" / "pack" / "leaf.py").write_text("A = 1\n", encoding="utf-8")

    Shipment.of(tmp_path / "home").unpack(tmp_path / "away")

    assert (tmp_path / "away" / "imported" / "pack" / "leaf.py").read_text() == "A = 1\n"
