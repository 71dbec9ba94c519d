"""Mutilated files, and a command in a process of its own: exit code 3, a place, and no change."""

import random
import re
import shutil
from pathlib import Path

import pytest

from m2t.metamodels import FAULTS_FILE, forget_metamodels
from mrsfi_runtime.cli.main import main
from mrsfi_runtime.errors import ModelError
from tests.support.cli import ROOT, mrsfi_process
from tests.support.models.copies import MISSION, copy_models
from tests.support.mutilation import MUTILATIONS, content
from tests.tiers import seeds


def _is_broken(folder: Path) -> bool:
    try:
        return main(["validate", str(folder)]) == ModelError.exit_code
    finally:
        forget_metamodels()


@pytest.mark.parametrize("kind", seeds(list(MUTILATIONS)[:3], 1))
def test_command_line_refuses_mutilated_models(tmp_path, kind):
    folder = copy_models(tmp_path)
    original = (folder / MISSION).read_bytes()
    draw = random.Random(f"command line {kind}")
    while not _is_broken(folder):
        (folder / MISSION).write_bytes(MUTILATIONS[kind](original, draw))
    before = content(folder)

    done = mrsfi_process("validate", folder, cwd=tmp_path, expected=3, timeout=30)

    assert re.search(r"\.xmi:[1-9][0-9]*: ", done.stdout + done.stderr)
    assert content(folder) == before


@pytest.mark.parametrize("kind", seeds(list(MUTILATIONS)[-3:], 1))
def test_command_line_refuses_mutilated_metamodels(tmp_path, installed, monkeypatch, kind):
    models = copy_models(tmp_path)
    original = (installed / FAULTS_FILE).read_bytes()
    draw = random.Random(f"command line {kind}")
    while not _is_broken(models):
        (installed / FAULTS_FILE).write_bytes(MUTILATIONS[kind](original, draw))
    shutil.copytree(
        ROOT / "m2t",
        tmp_path / "m2t",
        dirs_exist_ok=True,
        ignore=shutil.ignore_patterns("__pycache__"),
    )
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    monkeypatch.setenv("PYTHONDONTWRITEBYTECODE", "1")
    before = content(tmp_path)

    done = mrsfi_process("validate", models, cwd=tmp_path, expected=3, timeout=30)

    assert re.search(r"faults\.(ecore|xmi):[1-9][0-9]*: ", done.stdout + done.stderr)
    assert str(tmp_path) in done.stdout + done.stderr
    assert content(tmp_path) == before
