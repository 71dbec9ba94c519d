"""A thousand broken files: each ends the command with exit code 3, its place, and no change.

What a mutilation leaves valid is drawn as well, and counts for nothing.
"""

import random
import re
import shutil
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from m2t.metamodels import FAULTS_FILE, MISSION_FILE, load_metamodels, metamodel_folder
from mrsfi_runtime.cli.main import main
from mrsfi_runtime.errors import ModelError
from tests.model.mutilation import MUTILATIONS
from tests.support.cli import ROOT, mrsfi_process
from tests.support.models.copies import FAULTS, MISSION, copy_models

N_MODELS_EACH = 33
N_METAMODELS_EACH = 15
assert len(MUTILATIONS) * (N_MODELS_EACH + N_METAMODELS_EACH) >= 1_000
assert len(MUTILATIONS) * N_METAMODELS_EACH >= 300

MAX_DRAWS = 1_000
MAX_SECONDS = 5.0

_PLACE = re.compile(r"^(?P<path>.+?):(?P<line>[1-9][0-9]*): .+")


@pytest.fixture
def installed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """Lead the code to metamodels of its own, as an installation elsewhere would; their folder."""
    folder = tmp_path / "m2t" / "metamodels"
    folder.mkdir(parents=True)
    for name in (MISSION_FILE, FAULTS_FILE):
        shutil.copy(metamodel_folder() / name, folder / name)
    monkeypatch.setattr("m2t.metamodels.__file__", str(tmp_path / "m2t" / "metamodels.py"))
    yield folder
    load_metamodels.cache_clear()


def _content(folder: Path) -> dict[str, bytes]:
    files = (path for path in sorted(folder.rglob("*")) if path.is_file())
    return {str(path.relative_to(folder)): path.read_bytes() for path in files}


def _validate(models: Path, folder: Path, capsys: pytest.CaptureFixture[str]) -> int:
    """Validate models; require that every error has its place in a folder, and nothing else."""
    before = _content(folder)
    start = time.process_time()

    code = main(["validate", str(models)])

    assert time.process_time() - start < MAX_SECONDS
    assert _content(folder) == before
    out, err = capsys.readouterr()
    assert "Traceback" not in out + err
    if code == ModelError.exit_code:
        _require_places(out, err, folder)
    else:
        assert code == 0, out + err
    return code


def _require_places(out: str, err: str, folder: Path) -> None:
    """Require a place in every line of an error, whichever of the streams it is written to."""
    lines = [line for line in out.splitlines() if ": error: " in line] or err.splitlines()
    assert lines
    for line in lines:
        found = _PLACE.match(line.removeprefix("mrsfi: "))
        assert found, line
        assert Path(found["path"]).is_relative_to(folder), line
        assert len(line) < 2_000 + len(str(folder))


@pytest.mark.parametrize("kind", MUTILATIONS)
def test_mutilated_model_ends_with_exit_code_3_and_its_place(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], kind: str
) -> None:
    folder = copy_models(tmp_path)
    originals = _content(folder)
    draw = random.Random(f"models {kind}")
    n_broken = 0

    for _ in range(MAX_DRAWS):
        name = draw.choice([MISSION, FAULTS])
        (folder / name).write_bytes(MUTILATIONS[kind](originals[name], draw))
        n_broken += _validate(folder, tmp_path, capsys) == ModelError.exit_code
        (folder / name).write_bytes(originals[name])
        if n_broken == N_MODELS_EACH:
            break

    assert n_broken == N_MODELS_EACH


@pytest.mark.parametrize("kind", MUTILATIONS)
def test_mutilated_metamodel_ends_with_exit_code_3_and_its_place(
    tmp_path: Path, installed: Path, capsys: pytest.CaptureFixture[str], kind: str
) -> None:
    models = copy_models(tmp_path)
    originals = _content(installed)
    draw = random.Random(f"metamodels {kind}")
    n_broken = 0

    for _ in range(MAX_DRAWS):
        name = draw.choice([MISSION_FILE, FAULTS_FILE])
        (installed / name).write_bytes(MUTILATIONS[kind](originals[name], draw))
        load_metamodels.cache_clear()
        n_broken += _validate(models, tmp_path, capsys) == ModelError.exit_code
        (installed / name).write_bytes(originals[name])
        if n_broken == N_METAMODELS_EACH:
            break

    assert n_broken == N_METAMODELS_EACH


def _is_broken(folder: Path) -> bool:
    try:
        return main(["validate", str(folder)]) == ModelError.exit_code
    finally:
        load_metamodels.cache_clear()


@pytest.mark.parametrize("kind", list(MUTILATIONS)[:3])
def test_command_line_refuses_mutilated_models(tmp_path: Path, kind: str) -> None:
    folder = copy_models(tmp_path)
    original = (folder / MISSION).read_bytes()
    draw = random.Random(f"command line {kind}")
    while not _is_broken(folder):
        (folder / MISSION).write_bytes(MUTILATIONS[kind](original, draw))
    before = _content(folder)

    done = mrsfi_process("validate", folder, cwd=tmp_path, expected=3, timeout=30)

    assert re.search(r"\.xmi:[1-9][0-9]*: ", done.stdout + done.stderr)
    assert _content(folder) == before


@pytest.mark.parametrize("kind", list(MUTILATIONS)[-3:])
def test_command_line_refuses_mutilated_metamodels(
    tmp_path: Path, installed: Path, monkeypatch: pytest.MonkeyPatch, kind: str
) -> None:
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
    before = _content(tmp_path)

    done = mrsfi_process("validate", models, cwd=tmp_path, expected=3, timeout=30)

    assert re.search(r"faults\.(ecore|xmi):[1-9][0-9]*: ", done.stdout + done.stderr)
    assert str(tmp_path) in done.stdout + done.stderr
    assert _content(tmp_path) == before
