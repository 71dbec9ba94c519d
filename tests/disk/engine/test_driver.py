"""The cache of compiled missions keeps the newest."""

import os

import pytest

from mrsfi_runtime.engine.compiled import driver
from mrsfi_runtime.engine.compiled.driver import N_KEPT, Stub, load_driver


@pytest.mark.parametrize("n_before", [0, 1, N_KEPT // 2 + 3, N_KEPT - 1, N_KEPT, N_KEPT + 5])
def test_a_new_mission_takes_the_place_of_the_oldest_only_where_the_cache_is_full(
    tmp_path, monkeypatch, n_before
):
    monkeypatch.setenv("MRSFI_CACHE", str(tmp_path))
    monkeypatch.setattr(driver, "load_module", lambda _, path: path)
    made = load_driver(Stub("", "first"))
    cache = made.parents[1]
    os.utime(made, (0, 0))
    for k in range(n_before):
        path = cache / f"mission_{k}" / "flight.py"
        path.parent.mkdir()
        path.touch()
        os.utime(path, (k + 1, k + 1))

    new = load_driver(Stub("", "last"))

    before = [made.parent.name, *(f"mission_{k}" for k in range(n_before))]
    kept = {path.name for path in cache.iterdir()}
    assert kept == {*before[-(N_KEPT - 1) :], new.parent.name}
