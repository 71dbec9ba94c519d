"""How a command ends when its code prints or loops, and when nobody can read what it says."""

import json
import os
import shutil
import subprocess

import pytest

from tests.support.cli import command_line, mrsfi, mrsfi_process
from tests.support.edited import COLLECTIVE, indented, write_body
from tests.support.rendezvous import EITHER, NAME, harmless, write_planted, write_rendezvous


@pytest.fixture
def small(tmp_path):
    """Folder of a small mission, and what writes another body of its first check."""
    generated = write_rendezvous(tmp_path)
    return tmp_path, lambda body: write_body(generated / COLLECTIVE, "g1.check", indented(body))


def shell(line, cwd, **environment):
    """Run a line of bash in which ``mrsfi`` is the command of this Python."""
    words = " ".join(command_line())
    return subprocess.run(
        ["bash", "-c", f'mrsfi() {{ {words} "$@"; }}; {line}'],
        check=False,
        cwd=cwd,
        capture_output=True,
        encoding="utf-8",
        env=os.environ | environment,
        timeout=120,
    )


def test_what_a_region_prints_goes_to_standard_error(small):
    place, check = small
    check("import os\nos.system('echo SHELL')\nprint('REGION')\nreturn False")

    done = mrsfi_process("simulate", NAME, "--json", cwd=place)

    assert json.loads(done.stdout)["mission"]
    assert {"SHELL", "REGION"} <= set(done.stderr.split())


def test_a_region_that_nothing_stops_ends_the_command(small, monkeypatch):
    place, check = small
    monkeypatch.setenv("MRSFI_TIME_LIMIT", "0.5")
    line = check("while True:\n    try:\n        pass\n    except BaseException:\n        pass")

    done = mrsfi_process("simulate", NAME, cwd=place, expected=6)

    where, _, said = done.stderr.partition(": the mission ")
    number = int(where.rpartition(":")[2])
    assert line <= number <= line + 4
    assert "made no progress for 0.5 s; if it needs longer, set MRSFI_TIME_LIMIT" in said


@pytest.mark.parametrize("n_before", [0, 2])
def test_resume_is_advised_only_where_something_was_recorded(n_before, small):
    place, check = small
    check("if ci.robots[A].x < -50.0 and ci.mission.tick > 60:\n    raise KeyboardInterrupt")
    evolve = write_planted(place, [*harmless(n_before), EITHER])

    done = mrsfi(*evolve, "--workers", "1", "--out", "it", cwd=place, expected=130)

    lines = ["the results so far are kept; print them with: mrsfi report it"]
    lines += ["continue with: mrsfi evolve --resume it"]
    found = [line for line in done.stderr.splitlines() if " with: mrsfi " in line]
    assert found == (lines if n_before else [])


@pytest.mark.parametrize(
    ("line", "code", "said"),
    [
        ("mrsfi --version > /dev/full", 2, "standard output cannot be written: No space left"),
        ("mrsfi nonsense > /dev/full", 2, "No such command"),
        ("mrsfi --version >&-", 0, ""),
        ("mrsfi nonsense 2>&-", 2, ""),
        ("mrsfi nonsense 2> /dev/full", 2, ""),
        ("mrsfi --help | true; exit ${PIPESTATUS[0]}", 0, ""),
    ],
)
def test_a_command_ends_with_what_it_decided_whoever_reads_it(tmp_path, line, code, said):
    done = shell(line, tmp_path)

    assert done.returncode == code, done.stderr
    assert said in done.stderr
    assert "Traceback" not in done.stderr


def test_what_came_back_is_told_by_the_exit_code_though_nobody_reads_it(found, tmp_path):
    place = shutil.copytree(found, tmp_path, dirs_exist_ok=True)
    mrsfi("keep", "runs/it", "--weakness", "2", cwd=place)
    write_body(place / "generated" / NAME / COLLECTIVE, "g1.check", "    return True\n")

    done = shell("mrsfi check | true; exit ${PIPESTATUS[0]}", place)

    assert done.returncode == 10
    assert "exceeds its limit" in done.stderr


@pytest.mark.parametrize(
    "locale",
    [
        {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"},
        {"PYTHONIOENCODING": "ascii"},
    ],
    ids=["C", "ascii"],
)
def test_what_an_encoding_lacks_is_written_otherwise(small, locale):
    done = shell(f"mrsfi simulate {NAME}", small[0], **locale)

    assert done.returncode == 0, done.stderr
    assert done.stdout.isascii()
    assert "\\u2013" in done.stdout
