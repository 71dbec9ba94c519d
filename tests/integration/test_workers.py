"""Evaluation in several processes."""

import pickle

import pytest

from mrsfi_runtime.engine import recording
from mrsfi_runtime.engine.flights import ReferenceEngine
from mrsfi_runtime.engine.pools import WorkerPool
from mrsfi_runtime.generated_code import load_code
from mrsfi_runtime.model.faults import TimedFault
from mrsfi_runtime.model.mission import FailedFlight
from mrsfi_runtime.record.engine_settings import EngineSettings
from tests.support.edited import edited
from tests.support.world import ROOT, paper_code

GENERATED = ROOT / "generated" / "uuv_sampling"
SPECIFICATIONS = [
    (TimedFault(fault.id, 10 * number, 10 * number + 300, fault.values),)
    for number, fault in enumerate(paper_code().pool)
][:6]


def test_any_number_of_workers_gives_the_same_results_in_order():
    results = []
    for n_workers in (1, 2):
        with WorkerPool(load_code(GENERATED), 1, n_workers, EngineSettings()) as pool:
            results.append(list(pool.evaluate_many(SPECIFICATIONS)))

    assert results[0] == results[1]
    engine = ReferenceEngine(load_code(GENERATED), 1)
    assert results[0] == [engine.evaluate(specification) for specification in SPECIFICATIONS]


def test_workers_record_what_an_engine_here_would(monkeypatch):
    here = ReferenceEngine(load_code(GENERATED), 1)
    with WorkerPool(here.code, 1, 2, EngineSettings()) as pool:
        flown = [*pool.record_many(here, SPECIFICATIONS[:3])]

    monkeypatch.setattr(recording, "CHUNK", 1 << 20)  # so that some chunks are compressed
    for there, expected in zip(flown, here.record_many(here, SPECIFICATIONS[:3]), strict=True):
        assert len(expected) > 2 * expected.chunk
        ticks = ticks_of(expected)
        assert len(ticks) == here.code.mission.duration
        for each in (there, pickle.loads(pickle.dumps(expected))):
            assert each.tallies == expected.tallies
            assert ticks_of(each) == ticks


def ticks_of(recorded):
    return [tick.tobytes() for some in recorded.moments() for tick in some]


@pytest.mark.parametrize(
    ("n_workers", "body", "told"),
    [
        (1, "    return 1 // (len(ci.robots) - 3) > 9\n", "ZeroDivisionError"),
        (2, "    return 1 // (len(ci.robots) - 3) > 9\n", "ZeroDivisionError"),
        (2, "    import os\n    os._exit(0)\n", "SystemExit: 0"),
    ],
)
def test_a_failed_evaluation_comes_back_with_its_traceback(tmp_path, n_workers, body, told):
    folder = edited(tmp_path, "g2.check", body)

    with WorkerPool(load_code(folder), 1, n_workers, EngineSettings()) as pool:
        results = list(pool.evaluate_many(SPECIFICATIONS[:2]))

    assert all(isinstance(result, FailedFlight) for result in results)
    assert all(told in result.traceback for result in results)
