"""Projects whose collective intelligence is a team's own node, and what it leaves behind."""

import os
import shutil
import sys
from collections.abc import Mapping
from pathlib import Path
from time import monotonic, sleep

from m2t.generate import generate
from tests.support.processes import is_running
from tests.support.tree import ROOT

MISSION = "yard"
_WITHIN = 10.0
PYTHON = ("--side", "injector", "--node", f"{sys.executable} python/patrol.py {{url}}")
SERVICE = ("--node-reset", "service")
JAVASCRIPT = ("--side", "injector", "--node", "node javascript/patrol.mjs {url}")


def yard(folder: Path) -> Path:
    """Copy the example of nodes into a folder, and generate its code."""
    shutil.copytree(
        ROOT / "examples" / "nodes",
        folder,
        ignore=shutil.ignore_patterns("generated", "runs", "node_modules", "__pycache__"),
        dirs_exist_ok=True,
    )
    generate(folder / "models" / MISSION, folder / "generated" / MISSION)
    return folder


def processes_in(folder: Path) -> Mapping[int, str]:
    """Return the command lines of all processes that work in a folder, but for this one."""
    found = {}
    for process in Path("/proc").glob("[0-9]*"):
        try:
            if (process / "cwd").readlink() == folder.resolve():
                words = (process / "cmdline").read_bytes().split(b"\0")
                found[int(process.name)] = b" ".join(words).decode()
        except (FileNotFoundError, ProcessLookupError, PermissionError):
            continue
    return {pid: line for pid, line in found.items() if pid != os.getpid() and is_running(pid)}


def require_silence(place: Path) -> None:
    """Require that nothing is left running in a folder, after a moment."""
    limit = monotonic() + _WITHIN
    while processes_in(place) and monotonic() < limit:
        sleep(0.05)
    assert processes_in(place) == {}
