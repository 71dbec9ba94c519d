"""The example of six robots, eleven goals and all nine tasks, and what commands make of it."""

import os
import shutil
import subprocess
import sys

import pytest

from tests.support.cli import mrsfi, mrsfi_json
from tests.support.models.shapes import TASKS
from tests.support.tree import ROOT, UNDRAWN
from tests.tiers import slow

SCRIPT = ROOT / "examples" / "warehouse" / "warehouse.py"
NAME = "warehouse"
CAMPAIGN = f"runs/{NAME}-script-1"
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


@pytest.fixture
def place(flown, tmp_path):
    return shutil.copytree(flown[0], tmp_path / "place")


def test_it_is_written_flown_and_searched_by_an_unguarded_script(flown):
    folder, (counts, *weaknesses) = flown
    written = (folder / "models" / NAME / "mission.xmi").read_text(encoding="utf-8")

    assert len(SCRIPT.read_text(encoding="utf-8").splitlines()) < 100
    assert counts in (SCRIPT.parent / "README.md").read_text(encoding="utf-8")
    assert weaknesses
    assert all(f'xsi:type="mission:{task}"' in written for task in TASKS)
    assert (written.count("<robots "), written.count("<goals ")) == (6, 11)


def test_no_id_and_no_number_of_a_table_is_cut(place, monkeypatch):
    mrsfi("keep", CAMPAIGN, "--weakness", "1", cwd=place)
    goals = {goal["id"] for goal in mrsfi_json("simulate", NAME, cwd=place)["goals"]}
    explain = ("explain", CAMPAIGN, "--engine", "compiled")
    explained = mrsfi_json(*explain, cwd=place)["explanations"][0]
    cause = {str(fault[key]) for fault in explained["faults"] for key in ("id", "finish")}
    broken = mrsfi_json("weaknesses", CAMPAIGN, cwd=place)
    limits = mrsfi_json("check", NAME, cwd=place)[NAME][0]["max"]
    kept = {word for goal, most in limits.items() if most for word in (goal, str(most))}
    expected = {
        ("simulate", NAME): goals,
        explain: cause,
        ("check", NAME): kept,
        ("report", CAMPAIGN): {fault for each in broken for fault in each["faults"]},
    }
    monkeypatch.setenv("COLUMNS", "80")
    for command, words in expected.items():
        told = mrsfi(*command, cwd=place).stdout
        assert words, command
        assert words <= {*told.split()}, command
        assert "…" not in told.replace(" … ", ""), command  # but as in 2 … 196
