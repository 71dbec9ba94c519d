from pathlib import Path

import pytest

from tests.support.models.copies import copy_models
from tests.support.mutilation import installed  # noqa: F401 - a fixture


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Return a copy of the paper's mission folder, to be broken."""
    return copy_models(tmp_path)
