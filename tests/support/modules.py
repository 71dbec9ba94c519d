"""Modules that other tests have written and loaded into this process."""

import sys
from pathlib import Path

import pytest

from mrsfi_runtime.engine.source_hash import team_files
from mrsfi_runtime.mission import NOTHING_LOADED


@pytest.fixture
def old_modules(monkeypatch: pytest.MonkeyPatch) -> None:
    """Have no module of a team loaded whose file is younger than this process."""
    young = {
        str(path)
        for path in team_files()
        if not path.exists() or path.stat().st_mtime > NOTHING_LOADED
    }
    for name, module in [*sys.modules.items()]:
        if str(Path(getattr(module, "__file__", None) or "")) in young:
            monkeypatch.delitem(sys.modules, name)
