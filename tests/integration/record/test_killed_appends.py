"""Records whose writer is killed, or finds no room."""

import subprocess
import sys

from mrsfi_runtime.record.store import CampaignStore
from tests.support.campaigns import evaluation


def test_a_write_beyond_the_room_is_refused_and_what_was_stored_stays(tmp_path):
    folder = tmp_path / "run"
    script = FULL.format(folder=str(folder), path=sys.path)

    done = subprocess.run(
        [sys.executable, "-c", script], check=False, capture_output=True, encoding="utf-8"
    )

    cannot_begin, cannot_go_on = done.stdout.splitlines()
    assert "cannot be written to or read from the disk" in cannot_begin
    assert "--resume" not in cannot_begin
    assert f"free some space, then continue with: mrsfi evolve --resume {folder}" in cannot_go_on
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
