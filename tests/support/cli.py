"""Run the command line, in this process or one of its own, and workspaces to run it in."""

import json
import os
import shutil
import signal
import sqlite3
import subprocess
import sys
from collections.abc import Mapping, Sequence
from contextlib import chdir, closing, redirect_stderr, redirect_stdout
from io import StringIO
from pathlib import Path
from typing import Any

from mrsfi_runtime.cli.main import main
from tests.support.missing import skip
from tests.support.tree import ROOT, UNDRAWN

MISSION = "uuv_sampling"
SMALL = ("--population", "4", "--generations", "2", "--workers", "1")
"""Options of a campaign that takes a second."""

_SPECIFICATION = """<?xml version="1.0" encoding="ASCII"?>
<faults:FaultSpecification xmi:version="2.0" xmlns:xmi="http://www.omg.org/XMI" \
xmlns:faults="http://mrsfi.org/faults/1.0" ID="byhand">
{faults}</faults:FaultSpecification>
"""
_STOP = """  <faults ID="{id}" name="stop"{window}>
    <stopRobot>
      <affectedRobot href="mission.xmi#{robot}"/>
    </stopRobot>
  </faults>
"""


def mrsfi(*arguments: str | Path, cwd: Path, expected: int = 0) -> subprocess.CompletedProcess[str]:
    """Run ``mrsfi`` in this process, and require its exit code and that no traceback is seen.

    It saves the second in which a process starts; all but that is what a user calls.
    """
    words = [*map(str, arguments)]
    output, errors = StringIO(), StringIO()
    with chdir(cwd), redirect_stdout(output), redirect_stderr(errors):
        code = main(words)
    done = subprocess.CompletedProcess(words, code, output.getvalue(), errors.getvalue())
    return _required(done, expected)


def mrsfi_process(
    *arguments: str | Path,
    cwd: Path,
    expected: int = 0,
    timeout: float = 120.0,
    draws: bool = False,
) -> subprocess.CompletedProcess[str]:
    """Run ``mrsfi`` in a process of its own, with the same requirements; figures may stay empty."""
    path = [] if draws else [str(UNDRAWN)]
    path += filter(None, [os.environ.get("PYTHONPATH")])
    done = subprocess.run(
        command_line(*arguments),
        check=False,
        cwd=cwd,
        # That of Python: without what libraries set behind its back, such as COLUMNS.
        env=os.environ | {"PYTHONPATH": os.pathsep.join(path)},
        capture_output=True,
        encoding="utf-8",
        timeout=timeout,
    )
    return _required(done, expected)


def _required(
    done: subprocess.CompletedProcess[str], expected: int
) -> subprocess.CompletedProcess[str]:
    assert done.returncode == expected, done.stdout + done.stderr
    assert "Traceback" not in done.stdout + done.stderr
    return done


def command_line(*arguments: str | Path) -> list[str]:
    """Return the words that run ``mrsfi`` with this Python."""
    return [sys.executable, "-m", "mrsfi_runtime.cli.main", *map(str, arguments)]


def mrsfi_json(*arguments: str | Path, cwd: Path) -> Any:
    """Run ``mrsfi … --json`` and return what it printed."""
    return json.loads(mrsfi(*arguments, "--json", cwd=cwd).stdout)


def without_repetition(flown: dict[str, Any]) -> dict[str, Any]:
    """Return what ``simulate --json`` printed without what only external parts may vary."""
    left = {key: value for key, value in flown.items() if key not in {"flights", "late"}}
    goals = [{k: v for k, v in goal.items() if k != "broken_in"} for goal in flown["goals"]]
    return {**left, "goals": goals}


def press(pid: int) -> None:
    """Press Ctrl-C."""
    os.killpg(pid, signal.SIGINT)  # as a terminal does: the workers get it too


def interrupted(*arguments: str | Path, cwd: Path, sign: str) -> subprocess.CompletedProcess[str]:
    """Run ``mrsfi``, and press Ctrl-C once it wrote the sign to standard error."""
    with subprocess.Popen(
        command_line(*arguments),
        cwd=cwd,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        encoding="utf-8",
        start_new_session=True,
    ) as process:
        assert process.stderr is not None
        while sign not in process.stderr.readline():
            assert process.poll() is None
        press(process.pid)
        output, errors = process.communicate(timeout=120)
    return subprocess.CompletedProcess(process.args, process.returncode, output, errors)


def workspace(folder: Path, mission: str = MISSION) -> Path:
    """Copy models and generated code of a mission into a folder."""
    for name in ("models", "generated"):
        shutil.copytree(
            ROOT / name / mission,
            folder / name / mission,
            ignore=shutil.ignore_patterns("__pycache__", "*.mrsfi-*"),
        )
    return folder


def edit(path: Path, found: str, replaced: str) -> None:
    """Replace text that stands in a file."""
    text = path.read_text(encoding="utf-8")
    assert found in text
    path.write_text(text.replace(found, replaced), encoding="utf-8")


def stop_specification(
    path: Path, windows: Sequence[tuple[int, int] | None], robot: str = "r1"
) -> Path:
    """Write a specification that stops a robot in some windows, or without one."""
    faults = "".join(
        _STOP.format(
            id=f"h{number}",
            robot=robot,
            window="" if window is None else f' start="{window[0]}" finish="{window[1]}"',
        )
        for number, window in enumerate(windows, 1)
    )
    path.write_text(_SPECIFICATION.format(faults=faults), encoding="ascii")
    return path


def execute(campaign: Path, *statements: str) -> None:
    """Edit the record of a campaign."""
    with closing(sqlite3.connect(campaign / "campaign.sqlite")) as store, store:
        for statement in statements:
            store.execute(statement)


def contents(folder: Path) -> Mapping[str, tuple[bytes, int]]:
    """Return content and modification time of every file below a folder."""
    return {
        str(path.relative_to(folder)): (path.read_bytes(), path.stat().st_mtime_ns)
        for path in sorted(folder.rglob("*"))
        if path.is_file() and path.parent.name != "__pycache__"
    }


def require_program(name: str) -> str:
    """Return the path of a program, or skip the test; in continuous integration, fail it."""
    path = shutil.which(name)
    if path is None:
        skip(f"needs the program '{name}'")
    return path
