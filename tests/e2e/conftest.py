import fcntl
import json
import os
import shutil
import subprocess
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TypeAlias

import pytest

from mrsfi_runtime.analysis.summary import Illustration
from tests.support.cli import MISSION, SMALL, mrsfi_process, workspace
from tests.support.own_metamodels import own_metamodels  # noqa: F401 - a fixture
from tests.support.rendezvous import searched, write_rendezvous
from tests.support.rosbridge import process
from tests.support.undrawn import empty_figures

Ended: TypeAlias = subprocess.CompletedProcess[str]


@pytest.fixture(scope="module", autouse=True)
def undrawn() -> Iterator[None]:
    """Leave figures empty where nobody looks at them: drawing takes longer than most tests here.

    Only while a module runs, as workers go to and fro between the rooms. Processes of their own
    draw figures, unless ``UNDRAWN`` is on their path.
    """
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Illustration, "save", empty_figures.save)
        yield


@pytest.fixture
def place(tmp_path: Path) -> Path:
    """Folder with models/ and generated/ of the paper's mission."""
    return workspace(tmp_path)


def made_once(factory: pytest.TempPathFactory, name: str, make: Callable[[Path], object]) -> Path:
    """Return this worker's copy of a folder that the first of them fills, once in a run."""
    base = factory.getbasetemp()
    whole = (base.parent if "PYTEST_XDIST_WORKER" in os.environ else base) / f"shared_{name}"
    part = whole.with_suffix(".part")
    with whole.with_suffix(".lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not whole.exists():
            shutil.rmtree(part, ignore_errors=True)  # what an error has left
            part.mkdir()
            make(part)
            part.rename(whole)
    return Path(shutil.copytree(whole, factory.mktemp(name) / name))


@pytest.fixture(scope="session")
def flown(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder of a finished small campaign on goals g1 and g3, with figures; only to be read."""

    def make(folder: Path) -> None:
        words = ("evolve", MISSION, "--case", "b", *SMALL, "--out", "runs/small")
        mrsfi_process(*words, cwd=workspace(folder))
        mrsfi_process("report", "runs/small", cwd=folder, draws=True)

    return made_once(tmp_path_factory, "flown", make) / "runs" / "small"


@pytest.fixture
def campaign(flown: Path, tmp_path: Path) -> Path:
    """Copy of it, in a folder without models."""
    return Path(shutil.copytree(flown, tmp_path / "runs" / "copy"))


@pytest.fixture
def small(tmp_path: Path) -> Path:
    """Folder with models and generated code of a small mission, and no campaign."""
    write_rendezvous(tmp_path)
    return tmp_path


@pytest.fixture
def url() -> Iterator[str]:
    """Address of a server in a process of its own."""
    with process("bridge", "--port", "0") as server:
        assert server.stdout is not None
        yield server.stdout.readline().strip()


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
