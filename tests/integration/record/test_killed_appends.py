"""Records whose writer is killed, or finds no room."""

import signal
import subprocess
import sys
from pathlib import Path

from mrsfi_runtime.record.store import CampaignStore
from tests.support.campaigns import evaluation

WRITER = """
import os, signal, sys
from dataclasses import replace
from pathlib import Path
sys.path[:0] = {path!r}
from mrsfi_runtime.record import database
from mrsfi_runtime.record.store import CampaignStore
from mrsfi_runtime.record.engine_settings import Manifest
from mrsfi_runtime.record.settings import CampaignSettings
from tests.support.campaigns import evaluation
store = CampaignStore.create(Path({folder!r}), CampaignSettings(), Manifest())
for first in range(0, 30, 10):
    store.append([evaluation(i, (i,)) for i in range(first, first + 10)])
with database.transaction(store.path, store._connection) as connection:
    connection.execute("PRAGMA cache_spill = 1")
    connection.execute("PRAGMA cache_size = 1")
    row = connection.execute("SELECT * FROM evaluation WHERE idx = 29").fetchone()
    rows = [(i, row[1], row[2] * 2000, *row[3:]) for i in range(30, 60)]
    marks = ", ".join("?" * len(row))
    connection.executemany("INSERT INTO evaluation VALUES (" + marks + ")", rows)
    os.kill(os.getpid(), signal.SIGKILL)
"""


def test_a_kill_in_the_middle_of_an_append_loses_that_append_only(tmp_path):
    folder = tmp_path / "run"
    script = WRITER.format(folder=str(folder), path=sys.path)

    killed = subprocess.run([sys.executable, "-c", script], check=False)

    assert killed.returncode == -signal.SIGKILL
    assert Path(f"{folder / 'campaign.sqlite'}-journal").stat().st_size > 0
    with CampaignStore.open(folder) as store:
        assert tuple(store.evaluations()) == tuple(evaluation(i, (i,)) for i in range(30))
        store.append([evaluation(30, (30,))])
        assert store.n_evaluations == 31


def test_a_write_beyond_the_room_is_refused_and_what_was_stored_stays(tmp_path):
    folder = tmp_path / "run"
    script = FULL.format(folder=str(folder), path=sys.path)

    done = subprocess.run(
        [sys.executable, "-c", script], check=False, capture_output=True, encoding="utf-8"
    )

    cannot_begin, cannot_go_on = done.stdout.splitlines()
    assert "the disk did not take a write" in cannot_begin
    assert "--resume" not in cannot_begin
    assert f"free some room, then continue with: mrsfi evolve --resume {folder}" in cannot_go_on
    with CampaignStore.open(folder) as store:
        assert tuple(store.evaluations()) == (evaluation(0, (0,)),)


FULL = """
import resource, sys
from pathlib import Path
sys.path[:0] = {path!r}
from mrsfi_runtime.errors import RecordError
from mrsfi_runtime.record.store import CampaignStore
from mrsfi_runtime.record.engine_settings import Manifest
from mrsfi_runtime.record.settings import CampaignSettings
from tests.support.campaigns import evaluation
unlimited = resource.getrlimit(resource.RLIMIT_FSIZE)
resource.setrlimit(resource.RLIMIT_FSIZE, (4096, unlimited[1]))
try:
    CampaignStore.create(Path({folder!r}), CampaignSettings(), Manifest())
except RecordError as error:
    print(error)
resource.setrlimit(resource.RLIMIT_FSIZE, unlimited)
with CampaignStore.create(Path({folder!r}), CampaignSettings(), Manifest()) as store:
    store.append([evaluation(0, (0,))])
    size = store.path.stat().st_size
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))
    try:
        store.append([evaluation(i, (i,)) for i in range(1, 2000)])
    except RecordError as error:
        print(error)
"""
