"""Models and code that tests of generation edit."""

from pathlib import Path

import pytest

from m2t.generate import generate
from tests.support.models.copies import copy_models
from tests.support.own_metamodels import own_metamodels  # noqa: F401 - a fixture


@pytest.fixture
def models(tmp_path: Path) -> Path:
    """Folder of the paper's models, to be edited."""
    return copy_models(tmp_path, "uuv_sampling")


@pytest.fixture
def target(tmp_path: Path, models: Path) -> Path:
    """Folder of the code generated from them."""
    folder = tmp_path / "generated" / "uuv_sampling"
    generate(models, folder)
    return folder
