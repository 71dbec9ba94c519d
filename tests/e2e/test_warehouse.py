"""The example of six robots, eleven goals and all nine tasks, and what commands make of it."""

import os
import re
import shutil
import subprocess
import sys

import pytest

from tests.support.cli import contents, mrsfi, mrsfi_json
from tests.support.edited import write_body
from tests.support.tree import ROOT, UNDRAWN
from tests.tiers import slow

SCRIPT = ROOT / "examples" / "warehouse" / "warehouse.py"
NAME = "warehouse"
CAMPAIGN = f"runs/{NAME}-script-1"
TASKS = (
    "AvoidCollision",
    "StayWithinMissionArea",
    "SufficientEnergy",
    "FixedDistanceBetweenRobots",
    "GatherSamples",
    "Patrol",
    "Stay",
    "Track",
    "Visit",
)
ROBOTS = [f"carrier_{k}" for k in range(1, 7)]
NEW = {robot: f"loader-0{k}" for k, robot in enumerate(ROBOTS, 1)}
CARRIED = """    if ci.robots[CARRIER_1].x > 1000.0:
        return check_floor(ci)
    return goal_tasks.avoid_collision.violated(ci, COLLIDE)
"""

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


def test_all_robots_get_other_ids_at_once_and_nothing_else_changes(place):
    mrsfi("keep", CAMPAIGN, "--weakness", "1", cwd=place)
    code = place / "generated" / NAME / "collective_intelligence.py"
    write_body(code, "collide.check", CARRIED)
    shutil.copytree(place / "models", place / "old")
    before = contents(place)
    digest = mrsfi_json("simulate", NAME, cwd=place)["digest"]
    names = [f"{old}={new}" for old, new in NEW.items()]

    shown = mrsfi("rename", NAME, *names, "--diff", cwd=place).stdout
    assert contents(place) == before
    mrsfi("rename", NAME, *names, cwd=place)

    mrsfi("generate", NAME, "--check", cwd=place)
    assert mrsfi("validate", NAME, cwd=place).stdout.endswith("0 warnings\n")
    assert mrsfi_json("simulate", NAME, cwd=place)["digest"] == digest
    mrsfi("check", NAME, cwd=place)
    told = mrsfi("diff", f"old/{NAME}", f"models/{NAME}", cwd=place).stdout
    assert told.splitlines() == [f"robot {old} renamed {new}" for old, new in NEW.items()]
    after = contents(place)
    assert after.keys() == before.keys()
    changed = {name for name in after if after[name][0] != before[name][0]}
    assert f"generated/{NAME}/collective_intelligence.py" in changed
    for name in changed - {f"generated/{NAME}/manifest.json"}:
        assert f"--- {name}\n" in shown
        assert _back(after[name][0].decode()) == before[name][0].decode()


def _back(text: str) -> str:
    """Return a text with the old IDs, as long as the new ones, and their constants."""
    return re.sub(r"loader[-_]0(\d)", r"carrier_\1", text).replace("LOADER_0", "CARRIER_")
