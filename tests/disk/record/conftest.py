"""A campaign to write to, and a folder that cannot be written."""

import os
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from mrsfi_runtime.record.engine_settings import Manifest
from mrsfi_runtime.record.store import CampaignStore
from tests.support.campaigns import SETTINGS

NOBODY = 65534


@pytest.fixture
def store(tmp_path: Path) -> Iterator[CampaignStore]:
    with CampaignStore.create(tmp_path / "run", SETTINGS, Manifest()) as opened:
        yield opened


@pytest.fixture
def guest_folder() -> Iterator[Path]:
    """A folder that every user may enter, as pytest's own are not when root runs it."""
    with tempfile.TemporaryDirectory(dir="/tmp") as name:
        Path(name).chmod(0o755)
        yield Path(name)
        Path(name).chmod(0o755)


@pytest.fixture
def shut(guest_folder: Path) -> Iterator[Callable[[], None]]:
    """Let this process, root or not, write to that folder no more."""
    user = os.geteuid()

    def shut() -> None:
        guest_folder.chmod(0o555)
        if user == 0:
            os.seteuid(NOBODY)

    yield shut
    os.seteuid(user)
