"""What another version of the world's rules left behind is read, and refused where it would fly."""

import json
import sqlite3
import subprocess
import sys

import pytest

from mrsfi_runtime.model.semantics import SEMANTICS
from tests.support.cli import contents, edit, mrsfi, mrsfi_json, workspace
from tests.support.interrupted import MISSION
from tests.support.older_records import DIGEST_OF_1, recorded_by_1
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
def old(tmp_path):
    """Folder of a campaign of semantics 1."""
    return recorded_by_1(tmp_path / "old")


@pytest.fixture
def quick(tmp_path):
    """Folder with models/ and generated/ of the mission of 200 ticks."""
    return workspace(tmp_path, MISSION)


def test_an_older_campaign_is_reported(old, tmp_path):
    found = mrsfi_json("report", old, cwd=tmp_path)

    assert found["semantics"] == 1
    assert found["digest"] == DIGEST_OF_1
    assert found["mission"] == "tight_margins"
    assert found["best"]["evaluation"] == 1
    assert (found["best"]["believed"]["energy"], found["best"]["true"]["depths"]) == (171, 139)
    assert {*found["best"]["missed"].values(), *found["best"]["missed_since"].values()} == {None}
    assert [point["evaluation"] for point in found["front"]["points"]] == [1]
    summary = json.loads((old / "summary.json").read_text(encoding="utf-8"))
    assert summary == {key: value for key, value in found.items() if key != "folder"}
    report = (old / "report.md").read_text(encoding="utf-8")
    assert "semantics 1, the rules of mrsfi 0.1" in report
    assert "; what was missed is not recorded." in report
    assert "| 0 / 0 / ? | 0 / 0 / ? | 171 / 0 / ? | 127 / 139 / ? | 0 / 0 / ? |" in report
    assert len(list((old / "critical").iterdir())) == 3
    text = mrsfi("report", old, cwd=tmp_path).stdout
    assert "The 3 most critical of 3 fault specifications" in text
    assert text.count("missed from ?") == 3
    assert f"digest    {DIGEST_OF_1}" in text.splitlines()


@pytest.mark.parametrize(
    "words", [("replay",), ("replay", "--all"), ("evolve", "--resume"), ("evolve", "--seed", "9")]
)
def test_an_older_campaign_is_not_flown_and_stays_as_it_is(old, tmp_path, words):
    command = (*words, "--resume", old) if words[-1] == "9" else (*words, old)
    before = contents(old)

    error = mrsfi(*command, cwd=tmp_path, expected=9).stderr

    assert f"{old}: found semantics 1; expected semantics {SEMANTICS}" in error
    assert "fly the campaign with mrsfi 0.1, read it with `mrsfi report" in error
    assert "differ" not in error
    assert contents(old) == before


@pytest.mark.parametrize("other", ["", '"semantics": 1,'])
def test_code_generated_for_older_rules_is_refused_until_it_is_generated_anew(quick, other):
    flight = ("simulate", MISSION)
    edit(quick / "generated" / MISSION / "manifest.json", f"{NUMBER},", other)

    error = mrsfi(*flight, cwd=quick, expected=4).stderr

    assert f"generated/{MISSION}/manifest.json: found semantics 1; expected" in error
    assert "run `mrsfi generate`, then review the diff and your regions" in error
    mrsfi("generate", MISSION, cwd=quick)
    mrsfi(*flight, cwd=quick)


@slow
def test_a_comparison_is_not_continued_under_other_rules(quick):
    few = ("--algorithms", "random", "--evaluations", "2", "--workers", "1", "--seeds", "1")
    compare = ("compare", MISSION, *few, "--engine", "reference", "--out", "out")
    found = mrsfi_json(*compare, cwd=quick)
    with sqlite3.connect(quick / "out" / "runs" / "random-1" / "campaign.sqlite") as connection:
        ((text,),) = connection.execute("SELECT value FROM meta WHERE key = 'manifest'")
        manifest = json.dumps(json.loads(text) | {"semantics": 1, "versions": {"mrsfi": "0.1"}})
        connection.execute("UPDATE meta SET value = ? WHERE key = 'manifest'", (manifest,))
    before = contents(quick / "out" / "runs")

    error = mrsfi(*compare, cwd=quick, expected=9).stderr

    assert found["semantics"] == SEMANTICS
    assert f"out/runs/random-1: found semantics 1; expected semantics {SEMANTICS}" in error
    assert "fly the campaign with mrsfi 0.1" in error
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
