"""Evaluation on schedulers and workers that are processes of their own."""

from collections.abc import Iterator, Sequence
from pathlib import Path
from shutil import copytree

import pytest

from mrsfi_runtime.engine.flights import ReferenceEngine
from mrsfi_runtime.errors import EvaluationError, TransportError
from mrsfi_runtime.generated_code import load_code
from mrsfi_runtime.model.faults import Specification
from mrsfi_runtime.model.mission import FailedFlight
from mrsfi_runtime.record.engine_settings import COMPILED, REFERENCE, EngineSettings
from tests.support.cluster import Scheduler, require_dask, scheduler, without_mrsfi
from tests.support.edited import edited
from tests.support.world import ROOT, specifications
from tests.tiers import slow

require_dask()

import dask  # noqa: E402 - needs dask
import distributed  # noqa: E402 - needs dask

from mrsfi_runtime.engine import cluster  # noqa: E402 - needs dask
from mrsfi_runtime.engine.cluster import ClusterPool  # noqa: E402 - needs dask

MISSION = "tight_margins"
GENERATED = ROOT / "generated" / MISSION
SLOW_ENGINE = EngineSettings(REFERENCE)


@pytest.fixture(scope="module")
def two_workers(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Scheduler]:
    """A scheduler with two workers, one of them with two threads; nothing is killed there."""
    with scheduler(tmp_path_factory.mktemp("two"), 1) as found:
        found.start_worker(n_threads=2)
        found.wait_for_workers()
        yield found


@pytest.fixture(scope="module", name="specifications")
def drawn() -> list[Specification]:
    return specifications(load_code(GENERATED), 30, 6)


def pool_at(
    address: str, code: Path = GENERATED, settings: EngineSettings = SLOW_ENGINE, n_workers: int = 1
) -> ClusterPool:
    """Return an evaluator of a mission, with mission seed 1 by default."""
    return ClusterPool(address, n_workers, load_code(code), 1, settings)


@pytest.fixture(scope="module")
def expected(specifications: Sequence[Specification]) -> list[object]:
    """What the same specifications come to in this process."""
    with ReferenceEngine(load_code(GENERATED), 1) as pool:
        return list(pool.evaluate_many(specifications))


@slow
@pytest.mark.parametrize("name", [REFERENCE, pytest.param(COMPILED, marks=slow)])
def test_results_are_those_of_this_process_in_order(two_workers, specifications, expected, name):
    with pool_at(two_workers.address, settings=EngineSettings(name)) as pool:
        for order in (1, -1):
            assert list(pool.evaluate_many(specifications[::order])) == expected[::order]
        assert list(pool.evaluate_many([])) == []


def test_a_worker_gets_the_code_once_and_is_left_as_it_was(two_workers, specifications):
    folders = [worker.log.parent for worker in two_workers.workers]

    with pool_at(two_workers.address) as pool:
        for seed in (1, 2):
            list(pool.evaluate_many(specifications[:4], seed))
        during = [list(folder.rglob("mission_loader.py")) for folder in folders]

    assert [len(found) for found in during] == [1, 1]
    assert not [file for folder in folders for file in folder.rglob("mission_loader.py")]


def test_mission_seeds_are_kept_apart(two_workers, specifications):
    with pool_at(two_workers.address) as pool, ReferenceEngine(load_code(GENERATED), 2) as other:
        first, second = (list(pool.evaluate_many(specifications[:4], seed)) for seed in (1, 2))

        assert first != second == list(other.evaluate_many(specifications[:4]))


def test_a_region_that_fails_gives_the_failure_that_it_gives_here(
    two_workers, tmp_path, specifications
):
    body = "    return 1 // (99 - ci.mission.tick) > 9\n"
    folder = edited(tmp_path, "energy.check", body, MISSION)

    with ReferenceEngine(load_code(folder), 1) as here:
        expected = list(here.evaluate_many(specifications[:2]))
    with pool_at(two_workers.address, folder) as pool:
        found = list(pool.evaluate_many(specifications[:2]))

    assert all(isinstance(result, FailedFlight) for result in found)
    assert found == expected


def test_a_region_that_needs_what_the_worker_lacks_names_worker_and_remedy(
    two_workers, tmp_path, specifications, monkeypatch
):
    (tmp_path / "only_here.py").write_text("HIGHEST = 9\n", encoding="utf-8")
    monkeypatch.syspath_prepend(str(tmp_path))
    folder = edited(tmp_path, "imports", "from only_here import HIGHEST\n", MISSION)

    with (
        pool_at(two_workers.address, folder) as pool,
        pytest.raises(EvaluationError, match="No module named 'only_here'") as refused,
    ):
        list(pool.evaluate_many(specifications[:1]))

    assert "on the worker at tcp://127.0.0.1:" in str(refused.value)
    file = folder / "collective_intelligence.py"
    line = file.read_text(encoding="utf-8").splitlines().index("from only_here import HIGHEST") + 1
    assert f"{file}:{line}: cannot be imported" in str(refused.value)
    assert "have to be installed on every worker" in str(refused.value)


def test_a_search_that_stops_asking_leaves_the_workers_free(two_workers, specifications, expected):
    with pool_at(two_workers.address) as pool:
        asked = pool.evaluate_many(specifications)

        first = next(asked)
        asked.close()

        assert first == expected[0]
        assert list(pool.evaluate_many(specifications[:3])) == expected[:3]


@slow
def test_a_worker_that_joins_late_takes_over_from_one_that_died(tmp_path, specifications, expected):
    with scheduler(tmp_path, 1) as place, pool_at(place.address) as pool:
        before = list(pool.evaluate_many(specifications))
        place.workers[0].kill()
        place.start_worker()

        assert list(pool.evaluate_many(specifications)) == before == expected


@slow
def test_a_chunk_that_kills_its_workers_is_an_evaluation_error(tmp_path, specifications):
    body = "    import os\n    import signal\n\n    os.kill(os.getpid(), signal.SIGKILL)\n"
    folder = edited(tmp_path, "energy.check", body, MISSION)

    with (
        scheduler(tmp_path / "dask", 1, is_quick=True) as place,
        pool_at(place.address, folder) as pool,
        pytest.raises(EvaluationError, match="while they evaluated the same chunk"),
    ):
        list(pool.evaluate_many(specifications[:1]))


@slow
def test_when_the_last_worker_is_gone_the_user_is_told_how_to_start_one(
    tmp_path, specifications, monkeypatch
):
    with scheduler(tmp_path, 1) as place, pool_at(place.address) as pool:
        place.workers[0].kill()
        monkeypatch.setattr(cluster, "WORKER_SECONDS", 0.5)

        with pytest.raises(TransportError, match=f"start some with `dask worker {place.address}"):
            list(pool.evaluate_many(specifications))


def test_a_scheduler_without_workers_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(cluster, "WORKER_SECONDS", 0.5)

    with (
        scheduler(tmp_path, 0) as place,
        pytest.raises(TransportError, match=r"found no worker within 0\.5 s; start some with"),
    ):
        pool_at(place.address)


@slow
def test_a_worker_with_other_source_is_refused_also_when_it_joins_late(tmp_path, specifications):
    package = Path(copytree(ROOT / "src" / "mrsfi_runtime", tmp_path / "other" / "mrsfi_runtime"))
    with (package / "kernel" / "flight.py").open("a", encoding="utf-8") as file:
        file.write("# another one\n")
    other = {"PYTHONPATH": str(tmp_path / "other")}
    expected = r"the worker at \S+ would not give the same results: it has mrsfi \S.* \(source "

    with scheduler(tmp_path / "dask", 1) as place, pool_at(place.address) as pool:
        place.start_worker(other)
        place.wait_for_workers()
        with pytest.raises(TransportError, match=expected):
            list(pool.evaluate_many(specifications))
        with pytest.raises(TransportError, match=expected):
            pool_at(place.address)


@slow
def test_a_worker_without_mrsfi_is_refused(tmp_path):
    with scheduler(tmp_path / "dask", 0) as place:
        place.start_worker(without_mrsfi(tmp_path / "none"))
        with pytest.raises(
            TransportError, match=r"No module named 'mrsfi_runtime'.*expected the same"
        ):
            pool_at(place.address)


@slow
def test_a_local_cluster_is_reachable_from_this_machine_only(specifications, expected):
    with pool_at("local", n_workers=2) as pool:
        assert pool.n_workers == 2
        assert all("://127.0.0.1:" in address for address in pool._client.nthreads())
        assert list(pool.evaluate_many(specifications)) == expected


@slow
def test_a_cluster_with_certificates_is_reached_with_those_of_the_configuration(
    tmp_path, specifications, expected, monkeypatch
):
    security = distributed.Security.temporary()
    tls = {"distributed.comm.tls.ca-file": security.tls_ca_file}
    for role in ("scheduler", "worker", "client"):
        tls[f"distributed.comm.tls.{role}.cert"] = security.tls_client_cert
        tls[f"distributed.comm.tls.{role}.key"] = security.tls_client_key
    for key, value in tls.items():
        name = key.replace(".", "__").replace("-", "_").upper()
        monkeypatch.setenv(f"DASK_{name}", value)

    with (
        scheduler(tmp_path, 1, protocol="tls") as place,
        dask.config.set(tls),
        pool_at(place.address) as pool,
    ):
        found = list(pool.evaluate_many(specifications))

    assert place.address.startswith("tls://")
    assert found == expected
