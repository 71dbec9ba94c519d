"""A thousand broken files: each is still valid, or an error that names file and line."""

import random
import re
import shutil
from pathlib import Path

import pytest

from m2t.load import load_mission_folder
from m2t.metamodels import FAULTS_FILE, MISSION_FILE, metamodel_folder, read_metamodels
from mrsfi_runtime.errors import ModelError
from support_cli import mrsfi
from support_model import FAULTS, MISSION, copy_models
from support_mutilation import MUTILATIONS

N_MODELS_EACH = 35
N_METAMODELS_EACH = 13
assert len(MUTILATIONS) * (N_MODELS_EACH + N_METAMODELS_EACH) >= 1_000

_PLACE = re.compile(r"^(?P<path>.+?):(?P<line>[1-9][0-9]*): .+", re.DOTALL)


def _content(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in sorted(folder.iterdir())}


def _require_places(error: ModelError, folder: Path) -> None:
    for line in str(error).splitlines():
        found = _PLACE.match(line)
        assert found, line
        assert Path(found["path"]).is_relative_to(folder), line
        assert len(line) < 2_000 + len(str(folder))


@pytest.mark.parametrize("kind", MUTILATIONS)
def test_mutilated_model_is_valid_or_an_error_with_its_place(tmp_path: Path, kind: str) -> None:
    folder = copy_models(tmp_path)
    originals = _content(folder)
    draw = random.Random(f"models {kind}")

    for _ in range(N_MODELS_EACH):
        name = draw.choice([MISSION, FAULTS])
        (folder / name).write_bytes(MUTILATIONS[kind](originals[name], draw))
        before = _content(folder)

        try:
            load_mission_folder(folder)
        except ModelError as error:
            _require_places(error, folder)

        assert _content(folder) == before
        (folder / name).write_bytes(originals[name])


@pytest.mark.parametrize("kind", MUTILATIONS)
def test_mutilated_metamodel_is_valid_or_an_error_with_its_place(tmp_path: Path, kind: str) -> None:
    folder = tmp_path / "metamodels"
    folder.mkdir()
    for name in (MISSION_FILE, FAULTS_FILE):
        shutil.copy(metamodel_folder() / name, folder / name)
    originals = _content(folder)
    draw = random.Random(f"metamodels {kind}")

    for _ in range(N_METAMODELS_EACH):
        name = draw.choice([MISSION_FILE, FAULTS_FILE])
        (folder / name).write_bytes(MUTILATIONS[kind](originals[name], draw))
        before = _content(folder)

        try:
            read_metamodels(folder)
        except ModelError as error:
            _require_places(error, folder)

        assert _content(folder) == before
        (folder / name).write_bytes(originals[name])


@pytest.mark.parametrize("kind", list(MUTILATIONS)[:20])
def test_command_line_refuses_mutilated_models(tmp_path: Path, kind: str) -> None:
    folder = copy_models(tmp_path)
    originals = _content(folder)
    draw = random.Random(f"command line {kind}")
    message = None
    while message is None:
        (folder / MISSION).write_bytes(MUTILATIONS[kind](originals[MISSION], draw))
        try:
            load_mission_folder(folder)
        except ModelError as error:
            message = str(error)
    before = _content(folder)

    done = mrsfi("validate", folder, cwd=tmp_path, expected=3, timeout=30)

    assert re.search(r"\.xmi:[1-9][0-9]*: ", done.stdout + done.stderr)
    assert _content(folder) == before
