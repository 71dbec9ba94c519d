from pathlib import Path

import pytest

from tests.support.cli import MISSION, SMALL, mrsfi, workspace
from tests.support.mutilation import installed  # noqa: F401 - a fixture
from tests.support.own_metamodels import own_metamodels  # noqa: F401 - a fixture


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
