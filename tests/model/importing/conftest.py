"""A published file that holds the paper's models, and a folder to import it into."""

from pathlib import Path

import pytest

from m2t.models.load import LoadedModels, load_mission_folder
from tests.support.models.copies import MODELS
from tests.support.models.published import published


@pytest.fixture(scope="module")
def paper() -> LoadedModels:
    return load_mission_folder(MODELS)


@pytest.fixture(scope="module")
def text(paper: LoadedModels) -> str:
    return published(paper)


@pytest.fixture
def file(text: str, tmp_path: Path) -> Path:
    path = tmp_path / "published.xmi"
    path.write_text(text, encoding="ascii")
    return path


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return tmp_path / "models" / "imported"
