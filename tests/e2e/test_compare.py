import csv
import json
import os
import signal
import subprocess
from pathlib import Path
from typing import Any

import pytest

from tests.support.cli import MISSION, command_line, contents, edit, mrsfi, mrsfi_json, workspace
from tests.tiers import night, slow

FEW = ("--evaluations", "6", "--workers", "1", "--engine", "reference")
SMALL = ("compare", MISSION, "--case", "b", *FEW)


def findings(content: dict[str, Any]) -> dict[str, Any]:
    """Return what a comparison found, without what depends on machine and folder."""
    runs = [{k: v for k, v in run.items() if k != "seconds"} for run in content["runs"]]
    return {
        "tests": content["tests"],
        "runs": runs,
        "quartiles": {k: v for k, v in content["quartiles"].items() if k != "seconds"},
    }


@pytest.fixture(scope="module")
def compared(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, str]:
    """Place and standard output of a finished comparison with two seeds; only to be read."""
    folder = workspace(tmp_path_factory.mktemp("compared"))
    done = mrsfi(*SMALL, "--seeds", "2", cwd=folder)
    return folder, done.stdout


@slow
def test_it_prints_medians_tests_and_where_everything_is(compared):
    _, output = compared

    lines = output.splitlines()
    assert lines[0] == "3 algorithms, 2 seeds, 6 evaluations per run"
    assert any(line.split()[:2] == ["fitness", "paper"] for line in lines)
    assert any(line.startswith("hypervolume  share of the largest possible") for line in lines)
    assert lines[-1].split() == ["summary", "runs/compare-uuv_sampling-b/comparison.json"]
    assert max(map(len, lines)) <= 100


def test_the_folder_holds_runs_tables_and_figures(compared):
    folder = compared[0] / "runs" / "compare-uuv_sampling-b"

    assert sorted(file.name for file in (folder / "runs").iterdir()) == [
        f"{name}-{seed}" for name in ("drift", "paper", "random") for seed in (1, 2)
    ]
    assert sorted(file.name for file in (folder / "figures").glob("*.png")) == [
        "course.png",
        "goals.png",
        "results.png",
    ]
    with (folder / "runs.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert [row["n_evaluations"] for row in rows] == ["6"] * 6
    content = json.loads((folder / "comparison.json").read_text())
    assert (content["mission"], content["settings"]["goals"]) == (MISSION, ["g1", "g3"])
    assert len([test for test in content["tests"] if test["measure"] == "fitness"]) == 3


@slow
def test_what_is_finished_is_not_repeated_when_algorithms_and_seeds_are_added(place):
    out = ("--out", "runs/c")
    mrsfi(*SMALL, "--seeds", "1", "--algorithms", "random", *out, cwd=place)
    before = contents(place / "runs" / "c" / "runs")
    with (place / "models" / MISSION / "case_b.toml").open("a") as file:
        file.write("# of which nothing depends\n")

    done = mrsfi(*SMALL, "--seeds", "2", "--algorithms", "drift,random", *out, cwd=place)

    after = contents(place / "runs" / "c" / "runs")
    assert {name: after[name] for name in before} == before
    runs = ["drift-1", "drift-2", "random-1", "random-2"]
    assert sorted(file.name for file in (place / "runs" / "c" / "runs").iterdir()) == runs
    assert done.stderr.count("was finished already") == 1


SWEEP = (*SMALL, "--seeds", "2", "--sweep", "crossover=0.3:0.9:2,population=2")


@pytest.fixture(scope="module")
def swept(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, str]:
    """Place and standard output of a finished sweep; only to be read."""
    folder = workspace(tmp_path_factory.mktemp("swept"))
    return folder, mrsfi(*SWEEP, cwd=folder).stdout


@slow
@pytest.mark.parametrize(
    ("whole", "command", "name", "finished"),
    [
        ("compared", (*SMALL, "--seeds", "2"), "compare", ["paper-1", "random-1"]),
        pytest.param(
            "swept",
            SWEEP,
            "sweep",
            ["crossover=0.3,population=2-1", "crossover=0.9,population=2-1"],
            marks=night,
        ),
    ],
)
def test_after_a_kill_the_same_command_ends_as_if_nothing_had_happened(
    whole, command, name, finished, place, request
):
    name = f"runs/{name}-uuv_sampling-b"
    with subprocess.Popen(
        command_line(*command), cwd=place, stderr=subprocess.PIPE, stdout=subprocess.DEVNULL
    ) as process:
        while b"run 2/6" not in process.stderr.readline():
            pass
        os.kill(process.pid, signal.SIGKILL)
    runs = [place / name / "runs" / run for run in finished]
    before = [contents(run) for run in runs]

    again = mrsfi_json(*command, cwd=place)

    undisturbed, _ = request.getfixturevalue(whole)
    found = json.loads((undisturbed / name / "comparison.json").read_text())
    assert findings(again) == findings(found)
    assert again.get("sweep") == found.get("sweep")
    assert [contents(run) for run in runs] == before


@night
def test_a_sweep_prints_what_differs_from_the_papers_setting_and_keeps_tables_and_figures(swept):
    place, output = swept
    folder = place / "runs" / "sweep-uuv_sampling-b"

    lines = output.splitlines()
    assert lines[0] == "3 setups, 2 seeds, 6 evaluations per run: best fitness"
    said = "Of 2 setups beside the paper's, crossover=0.7,population=20: none differs"
    assert said in lines
    with (folder / "settings.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert [(row["crossover"], row["population"], row["verdict"]) for row in rows] == [
        ("0.3", "2", "not shown"),
        ("0.9", "2", "not shown"),
        ("0.7", "20", "the paper's"),
    ]
    content = json.loads((folder / "comparison.json").read_text())
    assert content["sweep"]["values"] == {"crossover": [0.3, 0.9], "population": [2]}
    assert content["settings"].keys().isdisjoint({"crossover", "population", "seed"})
    assert sorted(file.name for file in (folder / "figures").glob("*.png")) == [
        "heat_maps.png",
        "interactions.png",
    ]


@night
def test_what_is_edited_while_a_comparison_runs_changes_nothing(compared, place):
    command = (*SMALL, "--seeds", "2", "--json")
    with subprocess.Popen(
        command_line(*command), cwd=place, stderr=subprocess.PIPE, stdout=subprocess.PIPE
    ) as process:
        while b"run 1/6" not in process.stderr.readline():
            pass
        edit(place / "models" / MISSION / "mission.xmi", 'speed="5.0"', 'speed="6.0"')
        mrsfi("generate", MISSION, cwd=place)
        again = json.loads(process.communicate()[0])

    whole = json.loads((compared[0] / "runs/compare-uuv_sampling-b/comparison.json").read_text())
    assert findings(again) == findings(whole)


@night
def test_runs_of_another_number_of_evaluations_or_mission_are_not_mixed(place):
    small = (*SMALL, "--seeds", "1", "--algorithms", "random")
    mrsfi(*small, cwd=place)

    other = mrsfi(*small, "--evaluations", "7", cwd=place, expected=9)
    edit(place / "models" / MISSION / "mission.xmi", 'speed="5.0"', 'speed="6.0"')
    mrsfi("generate", MISSION, cwd=place)
    changed = mrsfi(*small, cwd=place, expected=9)

    assert "found a run with other evaluations: evaluations 6; expected evaluations 7" in (
        other.stderr
    )
    assert (
        "found a run with other manifest.json, mission.xmi, mission_loader.py: " in changed.stderr
    )


@slow
def test_a_run_is_the_campaign_of_its_seed_with_the_replications_of_its_file(place):
    file = place / "models" / MISSION / "case_b.toml"
    edit(file, "mission_seed = 1", "mission_seed = 1\nreplications = 2")
    random = ("evolve", MISSION, "--case", "b", "--algorithm", "random", "--seed", "2")

    found = mrsfi_json(*SMALL, "--algorithms", "random", "--seeds", "2", cwd=place)

    campaign = mrsfi_json(*random, *FEW, cwd=place)
    kept = place / "runs" / f"compare-{MISSION}-b" / "runs" / "random-2"
    run = found["runs"][1]
    assert found["settings"]["replications"] == 2
    assert run["digest"] == campaign["digest"]
    assert run["best_fitness"] == campaign["best"]["fitness"]
    assert run["front_size"] == len(campaign["front"]["points"])
    assert mrsfi_json("report", kept, cwd=place)["digest"] == run["digest"]
    mrsfi("replay", kept, "--all", cwd=place)


def test_a_folder_of_something_else_is_refused(place, approved):
    other = place / "runs" / "other"
    (other / "runs").mkdir(parents=True)
    (other / "campaign.sqlite").touch()
    before = contents(other)

    done = mrsfi(*SMALL, "--seeds", "1", "--out", other, cwd=place, expected=9)

    approved(done.stderr)
    assert contents(other) == before
