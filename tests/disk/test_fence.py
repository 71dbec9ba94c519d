"""What a team wrote is fenced: it fails as itself, whatever it does."""

import sys
from contextlib import suppress
from pathlib import Path

import pytest

from mrsfi_runtime.engine.flights import ReferenceEngine
from mrsfi_runtime.errors import EvaluationError, UsageError, WorkerLost
from mrsfi_runtime.generated_code import load_code, load_module
from mrsfi_runtime.model.mission import FailedFlight
from tests.support.edited import COLLECTIVE, edited, indented, write_body

FOREVER = "while True:\n    pass"


def fly(folder: Path, body: str = "return False", helpers: str = ""):
    """Fly the paper's mission with another body of a check, and other helpers."""
    code = edited(folder, "g1.check", indented(body))
    write_body(code / COLLECTIVE, "helpers", helpers)
    return ReferenceEngine(load_code(code), 1).evaluate(())


@pytest.fixture
def team(tmp_path, monkeypatch):
    """A module ``team`` that regions can import, forgotten again afterwards."""
    monkeypatch.syspath_prepend(tmp_path)
    yield tmp_path / "team.py"
    sys.modules.pop("team", None)


@pytest.mark.parametrize(
    ("body", "told"),
    [
        ("raise SystemExit(0)", "SystemExit: 0"),
        ("import sys\nsys.exit()", "SystemExit: "),
        ("import os\nos._exit(0)", "SystemExit: 0"),
        ("raise GeneratorExit", "GeneratorExit: "),
        ("raise StopIteration", "StopIteration: "),
        ("class Odd(BaseException): pass\nraise Odd('x')", "Odd: x"),
        ("class Odd(Exception):\n    __str__ = exit\nraise Odd", "Odd: "),
        ("return fly(ci)", "NameError: name 'fly' is not defined"),
    ],
)
def test_whatever_a_region_raises_is_its_error(tmp_path, body, told):
    with pytest.raises(EvaluationError, match=rf"{COLLECTIVE}:\d+: .* at tick 0: ") as failed:
        fly(tmp_path, body)

    assert told in str(failed.value)


@pytest.mark.parametrize("end", ["return False", "raise ValueError"])
def test_the_working_folder_is_put_back_after_it(tmp_path, monkeypatch, end):
    place, away = tmp_path / "place", tmp_path / "away"
    away.mkdir()
    place.mkdir()
    monkeypatch.chdir(place)

    with suppress(EvaluationError):
        fly(
            tmp_path,
            f"import os\nos.chdir({str(away)!r})\n{end}",
            f"import os\nos.chdir({str(away)!r})",
        )

    assert Path.cwd() == place


@pytest.mark.parametrize("text", ["import sys\nsys.exit(0)\n", "raise GeneratorExit\n"])
def test_a_helper_that_ends_the_process_is_an_error_of_the_line_that_imports_it(
    tmp_path, team, text
):
    team.write_text(text, encoding="utf-8")

    with pytest.raises(EvaluationError, match=rf"{COLLECTIVE}:\d+: cannot be imported: \w+Exit"):
        fly(tmp_path, helpers="import team\n")


def test_under_faults_it_is_a_failed_evaluation_and_ctrl_c_is_none(tmp_path):
    code = load_code(edited(tmp_path, "g1.check", "    raise SystemExit(0)\n"))

    assert isinstance(ReferenceEngine(code, 1).attempt(()), FailedFlight)
    with pytest.raises(KeyboardInterrupt):
        fly(tmp_path / "other", "raise KeyboardInterrupt")


def test_a_belief_that_is_no_number_at_the_end_is_an_error_of_the_mission(tmp_path):
    body = "if ci.mission.tick == 999:\n    ci.servers = ci.robots[0].x = ''\nreturn False"

    with pytest.raises(EvaluationError, match=r"at tick 999: "):
        fly(tmp_path, body)


@pytest.mark.parametrize(
    ("body", "helpers"),
    [
        (FOREVER, ""),
        (f"try:\n    {FOREVER[:11]} pass\nexcept Exception:\n    return False", ""),
        ("return False", f"{FOREVER}\n"),
    ],
    ids=["region", "region that catches errors", "import"],
)
def test_code_that_gets_no_further_is_stopped_by_its_line(tmp_path, monkeypatch, body, helpers):
    monkeypatch.setenv("MRSFI_TIME_LIMIT", "0.5")

    with pytest.raises(WorkerLost, match=rf"{COLLECTIVE}:\d+: .*no further for 0.5 s"):
        fly(tmp_path, body, helpers)


def test_what_time_has_stopped_is_no_result(tmp_path, monkeypatch):
    monkeypatch.setenv("MRSFI_TIME_LIMIT", "0.25")
    code = load_code(edited(tmp_path, "g1.check", indented(FOREVER)))

    with pytest.raises(WorkerLost):
        ReferenceEngine(code, 1).attempt(())


@pytest.mark.parametrize("seconds", ["1", "0"])
def test_what_gets_further_is_not_stopped(tmp_path, monkeypatch, seconds):
    monkeypatch.setenv("MRSFI_TIME_LIMIT", seconds)
    body = "import time\ntime.sleep(0.2 * (ci.mission.tick < 4))\nreturn False"

    assert fly(tmp_path, body).believed[0] == 0


def test_a_time_limit_that_is_none_is_told(tmp_path, monkeypatch):
    monkeypatch.setenv("MRSFI_TIME_LIMIT", "long")

    with pytest.raises(UsageError, match=r"MRSFI_TIME_LIMIT: found 'long'; expected seconds"):
        fly(tmp_path)


@pytest.mark.parametrize("kept", [0, 16, 40])
def test_damaged_bytecode_is_made_anew(tmp_path, monkeypatch, kept):
    monkeypatch.setattr(sys, "dont_write_bytecode", False)
    path = tmp_path / "damaged_team.py"
    path.write_text("SPEED = 4\n", encoding="utf-8")
    load_module("damaged_team", path)
    (cached,) = tmp_path.glob("__pycache__/*.pyc")
    cached.write_bytes(cached.read_bytes()[:kept])

    module = load_module("damaged_team", path)
    del sys.modules["damaged_team"]

    assert module.SPEED == 4
