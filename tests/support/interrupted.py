"""Campaigns that are begun, ended in the middle, and compared."""

import sqlite3
from contextlib import closing
from pathlib import Path
from typing import Any

from mrsfi.evolving import made
from mrsfi.folders import find_mission
from mrsfi_runtime.record.engine_settings import EngineSettings
from mrsfi_runtime.record.settings import CampaignSettings
from mrsfi_runtime.record.store import CampaignStore, Evaluation

MISSION = "tight_margins"
"""The mission of 200 ticks: an evaluation takes some ten milliseconds."""


def begin(path: Path, models: Path, settings: CampaignSettings) -> Path:
    """Make the folder of a campaign on a mission that is to be searched."""
    with made(path, find_mission(str(models)), settings, "a", EngineSettings()):
        return path


def evaluations(campaign: Path) -> tuple[Evaluation, ...]:
    """Return what a campaign has recorded; whoever opens it first undoes a half-done write."""
    with CampaignStore.open(campaign) as store:
        return tuple(store.evaluations())


def digest(campaign: Path) -> str:
    """Return the digest of a campaign."""
    with CampaignStore.open(campaign) as store:
        return store.digest()


def n_rows(campaign: Path, table: str) -> int:
    """Return how many rows a table of a campaign has, which may be running or not yet made."""
    path = campaign / "campaign.sqlite"
    if not path.is_file():
        return 0
    with closing(sqlite3.connect(f"file:{path}?mode=ro", uri=True)) as record:
        try:
            (count,) = record.execute(f"SELECT count(*) FROM {table}").fetchone()
        except sqlite3.OperationalError:  # not made yet
            return 0
    return int(count)


def rows(campaign: Path, table: str = "flight") -> list[tuple[Any, ...]]:
    """Return a table of a campaign, as it is stored."""
    with closing(sqlite3.connect(campaign / "campaign.sqlite")) as record:
        return record.execute(f"SELECT * FROM {table} ORDER BY idx").fetchall()


def is_equal(campaign: Path, other: Path) -> bool:
    """Return whether two campaigns keep and say the same of weaknesses, with figures or without."""
    files = ("summary.json", "report.md", "weaknesses/01.xmi", "tables/figure_12_weaknesses.csv")
    return rows(campaign) == rows(other) and all(
        _lines(campaign / name) == _lines(other / name) for name in files
    )


def _lines(path: Path) -> list[bytes]:
    return [line for line in path.read_bytes().split(b"\n") if line and line[:2] != b"!["]
