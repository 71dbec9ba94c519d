"""A campaign to write to."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from mrsfi_runtime.record.manifest import Manifest
from mrsfi_runtime.record.store import CampaignStore
from tests.support.campaigns import SETTINGS


@pytest.fixture
def store(tmp_path: Path) -> Iterator[CampaignStore]:
    with CampaignStore.create(tmp_path / "run", SETTINGS, Manifest()) as opened:
        yield opened
