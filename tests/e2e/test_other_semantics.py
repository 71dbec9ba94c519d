"""What another version of the world's rules left behind is read, and refused where it would fly."""

import subprocess
import sys

import pytest

from mrsfi_runtime.model.fault_types import SEMANTICS
from tests.support.cli import contents, edit, execute, mrsfi, workspace
from tests.support.interrupted import MISSION
from tests.support.rosbridge import process
from tests.tiers import seeds, slow

_LATER = """
import sys
from mrsfi_runtime.model import semantics
semantics.SEMANTICS += 1
from mrsfi_runtime.cli.main import main
sys.exit(main(sys.argv[1:]))
"""
"""The command line of a mrsfi whose rules are one version ahead."""

NUMBER = f'"semantics": {SEMANTICS}'


@pytest.fixture
def quick(tmp_path):
    """Folder with models/ and generated/ of the mission of 200 ticks."""
    return workspace(tmp_path, MISSION)


@pytest.mark.parametrize("words", [("replay",), ("evolve", "--resume")])
def test_a_campaign_of_later_rules_is_read_and_never_flown(campaign, tmp_path, words):
    later = NUMBER.replace(str(SEMANTICS), str(SEMANTICS + 1)).replace(" ", "")
    here = NUMBER.replace(" ", "")
    execute(campaign, f"UPDATE meta SET value = replace(value, '{here}', '{later}')")
    mrsfi("report", campaign, cwd=tmp_path)
    before = contents(campaign)

    error = mrsfi(*words, campaign, cwd=tmp_path, expected=9).stderr

    assert f"{campaign}: found semantics {SEMANTICS + 1}; expected semantics {SEMANTICS}" in error
    assert contents(campaign) == before


def test_code_generated_for_older_rules_is_refused_until_it_is_generated_anew(quick, approved):
    flight = ("simulate", MISSION)
    edit(quick / "generated" / MISSION / "manifest.json", f"{NUMBER},", "")

    error = mrsfi(*flight, cwd=quick, expected=4).stderr

    approved(error)
    mrsfi("generate", MISSION, cwd=quick)
    mrsfi(*flight, cwd=quick)


@slow
def test_a_comparison_of_before_0_3_is_not_continued(quick):
    few = ("--algorithms", "random", "--evaluations", "2", "--workers", "1", "--seeds", "1")
    compare = ("compare", MISSION, *few, "--engine", "reference", "--out", "out")
    mrsfi(*compare, cwd=quick)
    execute(quick / "out" / "runs" / "random-1", "PRAGMA user_version = 3")
    before = contents(quick / "out" / "runs")

    error = mrsfi(*compare, cwd=quick, expected=9).stderr

    assert "out/runs/random-1/campaign.sqlite: found a campaign of version 3, written by" in error
    assert contents(quick / "out" / "runs") == before


@slow
@pytest.mark.parametrize("is_later", seeds(["simulation", "ci"], 1))
def test_a_simulation_and_a_ci_of_different_rules_refuse_each_other(tmp_path, is_later):
    meet = ("simulate", MISSION, "--engine", "rosbridge", "--url")
    places = {}
    for side in ("simulation", "ci"):
        (tmp_path / side).mkdir()
        places[side] = workspace(tmp_path / side, MISSION)
    manifest = places[is_later] / "generated" / MISSION / "manifest.json"
    edit(manifest, NUMBER, f'"semantics": {SEMANTICS + 1}')

    def side(name, url):
        main = ("-c", _LATER) if name == is_later else ("-m", "mrsfi_runtime.cli.main")
        return subprocess.Popen(
            [sys.executable, *main, *meet, url, "--side", name, "--timeout", "3"],
            cwd=places[name],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            encoding="utf-8",
        )

    with process("bridge", "--port", "0") as server:
        url = server.stdout.readline().strip()
        with side("simulation", url) as simulation, side("ci", url) as ci:
            told = {"ci": ci.communicate(timeout=25)[1]}  # less than the CI waits for a simulation
            told["simulation"] = simulation.communicate(timeout=25)[1]

    mine, other = SEMANTICS + (is_later == "simulation"), SEMANTICS + (is_later == "ci")
    assert (ci.returncode, simulation.returncode) == (8, 8), told
    for text in told.values():
        assert f"semantics {mine} is what this simulation flies" in text
        assert f"/mission/setup asked for semantics {other}" in text
