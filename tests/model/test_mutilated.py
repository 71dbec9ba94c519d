"""A thousand broken files: each ends a command with exit code 3, its place, and no change.

What a mutilation leaves valid is drawn as well, and counts for nothing.
"""

import random
import re
import time
from collections.abc import Callable, Sequence
from pathlib import Path

import pytest

from m2t.metamodels import FAULTS_FILE, MISSION_FILE, read_metamodels
from mrsfi_runtime.cli.main import main
from mrsfi_runtime.errors import ModelError
from tests.support.models.copies import FAULTS, MISSION, copy_models
from tests.support.mutilation import MUTILATIONS, content
from tests.tiers import night, slow

N_MODELS_EACH = (3, pytest.param(33, marks=slow))
N_METAMODELS_EACH = (1, pytest.param(15, marks=night))
"""Of each kind of mutilation; at night a thousand, three hundred of them metamodels."""

MAX_DRAWS = 1_000
MAX_SECONDS = 30.0
"""Of work in this thread; what grows without bound takes longer."""

_PLACE = re.compile(r"^(?P<path>.+?):(?P<line>[1-9][0-9]*): .+")


def _validate(models: Path, folder: Path, capsys: pytest.CaptureFixture[str]) -> int:
    """Validate models; require that every error has its place in a folder, and nothing else."""
    before = content(folder)
    start = time.thread_time()

    code = main(["validate", str(models)])

    assert time.thread_time() - start < MAX_SECONDS
    assert content(folder) == before
    out, err = capsys.readouterr()
    assert "Traceback" not in out + err
    if code == ModelError.exit_code:
        _require_places(out, err, folder)
    else:
        assert code == 0, out + err
    return code


def _require_places(out: str, err: str, folder: Path) -> None:
    """Require a place in every line of an error, whichever of the streams it is written to."""
    told = [line for line in err.splitlines() if not line.startswith("metamodels ")]
    lines = [line for line in out.splitlines() if ": error: " in line] or told
    assert lines
    for line in lines:
        found = _PLACE.match(line.removeprefix("mrsfi: "))
        assert found, line
        assert Path(found["path"]).is_relative_to(folder), line
        assert len(line) < 2_000 + len(str(folder))


def _mutilate(kind: str, files: Sequence[Path], n_wanted: int, validate: Callable[[], int]) -> None:
    """Break one of the files again and again, until so many are refused; it is whole at the end."""
    originals = {path: path.read_bytes() for path in files}
    draw = random.Random(f"{files[0].suffix} {kind}")
    n_broken = 0
    for _ in range(MAX_DRAWS):
        path = draw.choice(files)
        path.write_bytes(MUTILATIONS[kind](originals[path], draw))
        n_broken += validate() == ModelError.exit_code
        path.write_bytes(originals[path])
        if n_broken == n_wanted:
            return
    pytest.fail(f"{n_broken} of {n_wanted} were refused")


@pytest.mark.parametrize("n_wanted", N_MODELS_EACH)
@pytest.mark.parametrize("kind", MUTILATIONS)
def test_mutilated_model_ends_with_exit_code_3_and_its_place(
    tmp_path, folder, capsys, kind, n_wanted
):
    files = [folder / MISSION, folder / FAULTS]
    _mutilate(kind, files, n_wanted, lambda: _validate(folder, tmp_path, capsys))


@pytest.mark.parametrize("n_wanted", N_METAMODELS_EACH)
@pytest.mark.parametrize("kind", MUTILATIONS)
def test_mutilated_metamodel_ends_with_exit_code_3_and_its_place(
    tmp_path, installed, capsys, kind, n_wanted
):
    models = copy_models(tmp_path)
    files = [installed / MISSION_FILE, installed / FAULTS_FILE]

    def validate() -> int:
        read_metamodels.cache_clear()
        return _validate(models, tmp_path, capsys)

    _mutilate(kind, files, n_wanted, validate)
