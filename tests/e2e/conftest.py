import json
import subprocess
from collections.abc import Iterator
from contextlib import nullcontext
from pathlib import Path
from types import SimpleNamespace
from typing import TypeAlias

import pytest

from mrsfi import reporting
from mrsfi_runtime.analysis import drawing
from tests.support.cli import MISSION, SMALL, mrsfi_process, workspace
from tests.support.mutilation import installed  # noqa: F401 - a fixture
from tests.support.own_metamodels import own_metamodels  # noqa: F401 - a fixture
from tests.support.rendezvous import searched, write_rendezvous
from tests.support.shared import made_once

Ended: TypeAlias = subprocess.CompletedProcess[str]


@pytest.fixture(scope="module", autouse=True)
def undrawn() -> Iterator[None]:
    """Leave figures empty where nobody looks at them: drawing takes longer than most tests here.

    Only while a module runs, as workers go to and fro between the rooms. Processes of their own
    draw figures, unless ``UNDRAWN`` is on their path.
    """
    empty = {".png": b"", ".svg": b""}
    here = nullcontext(SimpleNamespace(draw=drawing.draw_here))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(drawing, "drawn", lambda _: empty)
        for room in (drawing, reporting):
            patch.setattr(room, "DrawingProcess", lambda *_: here)
        yield


@pytest.fixture
def place(tmp_path: Path) -> Path:
    """Folder with models/ and generated/ of the paper's mission."""
    return workspace(tmp_path)


@pytest.fixture(scope="session")
def flown(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder of a finished small campaign on goals g1 and g3, with figures; only to be read."""

    def make(folder: Path) -> None:
        words = ("evolve", MISSION, "--case", "b", *SMALL, "--out", "runs/small")
        mrsfi_process(*words, cwd=workspace(folder), draws=True)

    return made_once(tmp_path_factory, "flown", make) / "runs" / "small"


@pytest.fixture(scope="session")
def ended(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Ended]:
    """Folder of a campaign that looked for weaknesses, and what was printed.

    It is only to be read.
    """

    def make(folder: Path) -> None:
        write_rendezvous(folder / "place")
        words = (*searched(folder / "place"), "--workers", "1", "--out", "runs/it")
        done = mrsfi_process(*words, cwd=folder / "place")
        told = json.dumps((done.args, done.returncode, done.stdout, done.stderr))
        (folder / "told.json").write_text(told, encoding="utf-8")

    folder = made_once(tmp_path_factory, "ended", make)
    told = json.loads((folder / "told.json").read_text(encoding="utf-8"))
    return folder / "place" / "runs" / "it", Ended(*told)


@pytest.fixture(scope="session")
def found(ended: tuple[Path, Ended]) -> Path:
    """Folder of the small mission of that campaign, which is in runs/it; only to be read."""
    return ended[0].parents[1]
