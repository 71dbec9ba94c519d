from contextlib import nullcontext
from pathlib import Path
from types import SimpleNamespace

import pytest

from mrsfi import reporting
from mrsfi_runtime.analysis import drawing
from mrsfi_runtime.cli import evolve
from tests.support.cli import MISSION, SMALL, mrsfi, workspace
from tests.support.mutilation import installed  # noqa: F401 - a fixture
from tests.support.own_metamodels import own_metamodels  # noqa: F401 - a fixture
from tests.support.rendezvous import PLANTED, harmless, write_planted, write_rendezvous


@pytest.fixture(autouse=True)
def undrawn(monkeypatch: pytest.MonkeyPatch) -> None:
    """Leave figures empty where nobody looks at them: drawing takes longer than most tests here.

    Fixtures of a session have them drawn, and so have processes of their own.
    """
    empty = {".png": b"", ".svg": b""}
    here = nullcontext(SimpleNamespace(draw=drawing.draw_here))
    monkeypatch.setattr(drawing, "drawn", lambda _: empty)
    for room in (evolve, reporting):
        monkeypatch.setattr(room, "DrawingProcesses", lambda *_: here)


@pytest.fixture
def place(tmp_path: Path) -> Path:
    """Folder with models/ and generated/ of the paper's mission."""
    return workspace(tmp_path)


@pytest.fixture(scope="session")
def flown(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder of a finished small campaign on goals g1 and g3; only to be read."""
    folder = workspace(tmp_path_factory.mktemp("flown"))
    mrsfi("evolve", MISSION, "--case", "b", *SMALL, "--out", "runs/small", cwd=folder)
    return folder / "runs" / "small"


@pytest.fixture(scope="session")
def found(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder of a small mission, with a campaign in runs/it; only to be read."""
    folder = tmp_path_factory.mktemp("found")
    write_rendezvous(folder)
    evolve = write_planted(folder, [*PLANTED, *harmless(130 - len(PLANTED))])
    mrsfi(*evolve, "--workers", "1", "--out", "runs/it", cwd=folder)
    return folder
