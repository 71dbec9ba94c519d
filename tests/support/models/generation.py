"""Missions of other shapes than the paper's to generate from, and what is generated."""

import subprocess
import sys
from pathlib import Path

from tests.support.tree import ROOT

GENERATED = ROOT / "generated" / "uuv_sampling"
FILES = (
    "mission_loader.py",
    "fault_loader.py",
    "fault_effects.py",
    "topics.py",
    "sim_interface.py",
    "simulation.py",
    "collective_intelligence.py",
)

_HERE = Path(__file__).parent
ALL_TASKS = (_HERE / "all_tasks.xmi").read_text(encoding="ascii")
"""All nine tasks, properties of every type, a robot without sensors, IDs in need of translation."""

BARE = (_HERE / "bare.xmi").read_text(encoding="ascii")
"""As little as a mission may hold: one robot, one goal, no sensor, no obstacle, no server."""


def write_mission(folder: Path, name: str, mission: str) -> Path:
    """Return a mission folder with this mission and no faults."""
    models = folder / "models" / name
    models.mkdir(parents=True)
    (models / "mission.xmi").write_text(mission)
    return models


def contents(folder: Path) -> dict[str, str]:
    """Return the texts of all files of a folder by name."""
    return {path.name: path.read_text() for path in sorted(folder.iterdir()) if path.is_file()}


def run_module(module: str, *arguments: str | Path, **environment: str) -> str:
    """Run a Python module in the project's root and return what it printed."""
    done = subprocess.run(
        [sys.executable, "-m", module, *map(str, arguments)],
        cwd=ROOT,
        env=environment or None,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout
