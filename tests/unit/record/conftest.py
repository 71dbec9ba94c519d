"""A campaign to write to."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from mrsfi_runtime.record.campaign import CampaignStore
from tests.support.campaigns import SETTINGS


@pytest.fixture
def store(tmp_path: Path) -> Iterator[CampaignStore]:
    with CampaignStore.create(tmp_path / "run", SETTINGS, {"version": "1"}) as opened:
        yield opened
