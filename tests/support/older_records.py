"""Campaigns as earlier releases of mrsfi recorded them."""

import shutil
import sqlite3
from contextlib import closing
from pathlib import Path

from tests.support.tree import ROOT

RECORDS = ROOT / "tests" / "support" / "records"
DIGEST_OF_1 = "7c262a561fabafbd24c758100086c30fa9225b03a6a8180d19c577e2ffcea3c5"
"""What mrsfi 0.1 printed of its campaign."""


def recorded_by_1(folder: Path) -> Path:
    """Make a campaign of semantics 1 in a folder, and return it.

    Models and rows are those that mrsfi 0.1.0 wrote: ``evolve`` on tight_margins with 3
    individuals of 3 faults, goals energy and depths. The generated code is not kept; what stands
    in its place fails when it is loaded, as code of an earlier mrsfi may.
    """
    shutil.copytree(RECORDS / "semantics_1", folder, ignore=shutil.ignore_patterns("*.sql"))
    rows = (RECORDS / "semantics_1" / "campaign.sql").read_text(encoding="utf-8")
    with closing(sqlite3.connect(folder / "campaign.sqlite")) as connection:
        connection.executescript(rows)
    (folder / "generated").mkdir()
    for name in ("collective_intelligence.py", "mission_loader.py", "fault_loader.py"):
        (folder / "generated" / name).write_text("raise RuntimeError\n", encoding="utf-8")
    return folder
