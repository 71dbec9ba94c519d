"""The reference engine, the pool of workers around it, and addresses of engines."""

from dataclasses import replace

import pytest

from mrsfi_runtime.engine.flights import ReferenceEngine
from mrsfi_runtime.errors import EvaluationError, UsageError
from mrsfi_runtime.generated_code import load_code
from mrsfi_runtime.model.faults import TimedFault
from mrsfi_runtime.record.engine_settings import require_address
from tests.support.cluster import require_dask
from tests.support.edited import edited
from tests.support.world import ROOT, paper_code

GENERATED = ROOT / "generated" / "uuv_sampling"


def test_an_error_in_a_region_names_its_line_mission_tick_and_cause(tmp_path):
    body = "    return 1 // (500 - ci.mission.tick) > 9\n"
    folder = edited(tmp_path, "g2.check", body)
    path = folder / "collective_intelligence.py"
    line = path.read_text(encoding="utf-8").splitlines().index(body.rstrip()) + 1

    with pytest.raises(EvaluationError) as failed:
        ReferenceEngine(load_code(folder), 1).evaluate(())

    expected = f"{path}:{line}: the mission failed at tick 500: ZeroDivisionError: "
    assert str(failed.value).startswith(expected)


def test_a_region_that_does_not_compile_is_named_with_its_file(tmp_path, refused):
    folder = edited(tmp_path, "g2.check", "    return (\n")

    with refused(EvaluationError):
        load_code(folder)


def test_two_folders_of_one_mission_do_not_share_code(tmp_path):
    folder = edited(tmp_path, "g2.check", "    return True\n")

    first, second = load_code(GENERATED), load_code(folder)

    assert ReferenceEngine(first, 1).evaluate(()).believed[1] == 0
    assert ReferenceEngine(second, 1).evaluate(()).believed[1] == 1000


def test_a_mission_of_one_tick_flies():
    code = paper_code()
    short = replace(code, mission=replace(code.mission, duration=1))

    outcome = ReferenceEngine(short, 1).evaluate((TimedFault("f26", 0, 0),))

    assert outcome.applied == (1,)


@pytest.mark.parametrize("text", ["local", "tcp://127.0.0.1:8786", "tls://[::1]:8786"])
def test_addresses_of_schedulers_are_taken(text):
    require_dask()

    require_address(text)


@pytest.mark.parametrize(
    "text",
    ["", "remote", "127.0.0.1:8786", "tcp://host", "tcp://:8786", "ws://host:1", "tcp://h:x"],
)
def test_what_is_no_address_is_refused_with_what_was_expected(text, refused):
    require_dask()

    with refused(UsageError):
        require_address(text)


def test_an_address_with_tls_is_refused_while_no_certificates_are_configured(refused):
    require_dask()
    from mrsfi_runtime.engine.cluster import Cluster

    with refused(UsageError):
        Cluster("tls://127.0.0.1:8786")
