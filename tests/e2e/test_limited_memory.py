"""On a machine that limits the address space of a process, as some build servers do."""

import os
import subprocess

import pytest

from mrsfi import loading
from mrsfi_runtime.cli.main import main
from tests.support.cli import command_line, workspace

MISSION = "tight_margins"
NOT_LOADED = (
    "the compiled engine cannot be loaded: Could not find/load shared object file 'libllvmlite.so' "
)
LIMITED = "this machine limits memory or processes (`ulimit -v`, `ulimit -u`); allow more"
EVOLVE = ("evolve", MISSION, "--evaluations", "4", "--population", "4", "--no-explain")


@pytest.fixture
def limited(tmp_path):
    """Run a command in a workspace under limits of the shell, and return what came of it."""
    place = workspace(tmp_path, MISSION)

    def run(limits, *arguments):
        return subprocess.run(
            ["sh", "-c", f'ulimit {limits} && exec "$@"', "sh", *command_line(*arguments)],
            check=False,
            cwd=place,
            env=os.environ | {"OPENBLAS_NUM_THREADS": "1"},  # each takes 32 MB
            capture_output=True,
            encoding="utf-8",
            timeout=240,
        )

    return run


def test_where_the_compiler_cannot_be_loaded_the_reference_engine_flies_and_it_is_said(limited):
    done = limited("-v 300000", *EVOLVE, "--workers", "1", "--out", "r")

    told = done.stderr.splitlines()[0]
    assert told.startswith(f"not compiled: {NOT_LOADED}")
    assert told.endswith(f"; {LIMITED}; mrsfi uses the reference engine, about 100 times slower")
    assert ("reference engine, 1 worker\n" in done.stderr, done.returncode) == (True, 0)


def test_the_compiled_engine_says_what_it_lacks(limited):
    done = limited("-v 300000", "simulate", MISSION, "--no-faults", "--engine", "compiled")

    assert done.stderr.startswith(f"mrsfi: {NOT_LOADED}")
    assert done.stderr.endswith(f"; {LIMITED}\n")
    assert done.returncode == 6


def test_where_no_thread_can_be_started_the_limit_is_named_and_not_the_mission(limited):
    limits = "-v 400000 && ulimit -s 390000"  # which a thread reserves for its stack
    told = f"can't start new thread: {LIMITED}\n"

    validated = limited(limits, "validate", MISSION)
    simulated = limited(limits, "simulate", MISSION, "--no-faults")

    assert validated.stderr == f"not flown without faults: {told}"
    assert validated.stdout.startswith(f"ok: {MISSION}: ")
    assert (simulated.stderr, simulated.returncode) == (f"mrsfi: {told}", 2)


def test_where_memory_runs_out_the_limit_is_named(monkeypatch, capsys):
    def validate(*_):
        raise MemoryError

    monkeypatch.setattr(loading, "validate", validate)

    assert (main(["validate", MISSION]), capsys.readouterr().err) == (
        2,
        f"mrsfi: no more memory: {LIMITED}\n",
    )
