"""Copies of the paper's models that tests may break."""

import shutil
from pathlib import Path

from tests.support.tree import ROOT

MODELS = ROOT / "models" / "uuv_sampling"
MISSION = "mission.xmi"
FAULTS = "faults.xmi"


def copy_models(folder: Path, name: str = "uuv") -> Path:
    """Copy the paper's mission folder below a folder and return the copy."""
    passing = shutil.ignore_patterns("*.mrsfi-*")  # of another test that generates
    return Path(shutil.copytree(MODELS, folder / "models" / name, ignore=passing))


def edit(path: Path, old: str, new: str) -> None:
    """Replace the first occurrence of a text, which has to be there."""
    text = path.read_text(encoding="utf-8")
    assert old in text, f"{old!r} is not in {path.name}"
    path.write_text(text.replace(old, new, 1), encoding="utf-8")


def line_of(path: Path, fragment: str) -> int:
    """Return the line, counted from 1, in which a fragment first occurs."""
    lines = path.read_text(encoding="utf-8").splitlines()
    return next(number for number, line in enumerate(lines, 1) if fragment in line)
