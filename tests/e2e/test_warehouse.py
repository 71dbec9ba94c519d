"""The example of six robots, eleven goals and all nine tasks, and what commands make of it."""

import os
import subprocess
import sys

import pytest

from tests.support.models.shapes import TASKS
from tests.support.tree import ROOT, UNDRAWN
from tests.tiers import slow

SCRIPT = ROOT / "examples" / "warehouse" / "warehouse.py"
NAME = "warehouse"
pytestmark = slow


@pytest.fixture(scope="module")
def flown(tmp_path_factory):
    """The folder in which the script ran, once, and what it printed."""
    folder = tmp_path_factory.mktemp("warehouse")
    done = subprocess.run(
        [sys.executable, str(SCRIPT), str(folder)],
        env={
            "PYTHONPATH": f"{ROOT}:{UNDRAWN}",
            "MRSFI_CACHE": os.environ["MRSFI_CACHE"],
            "PATH": "",
        },
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.stderr == ""
    return folder, done.stdout.splitlines()


def test_it_is_written_flown_and_searched_by_an_unguarded_script(flown):
    folder, (counts, *weaknesses) = flown
    written = (folder / "models" / NAME / "mission.xmi").read_text(encoding="utf-8")

    assert len(SCRIPT.read_text(encoding="utf-8").splitlines()) < 100
    assert counts in (SCRIPT.parent / "README.md").read_text(encoding="utf-8")
    assert weaknesses
    assert all(f'xsi:type="mission:{task}"' in written for task in TASKS)
    assert (written.count("<robots "), written.count("<goals ")) == (6, 11)
