"""What a campaign of algorithm cover has found is true, and told in names, figures and JSON."""

import csv
import re
import shutil
from xml.etree import ElementTree as ET

import pytest

import mrsfi as api
from mrsfi_runtime.model.faults import TimedFault
from tests.support.cli import execute, mrsfi, mrsfi_json, workspace
from tests.support.weaknesses import untried_by_hand

MISSION = "tight_margins"
REFERENCE = ("--engine", "reference", "--workers", "1")


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    """Folder of a project with a campaign that covers."""
    folder = workspace(tmp_path_factory.mktemp("place"), MISSION)
    cover = ("--algorithm", "cover", "--evaluations", "400", "--no-explain")
    mrsfi("evolve", MISSION, *cover, *REFERENCE, "--out", "runs/cover", cwd=folder)
    return folder


@pytest.fixture(scope="module")
def second(place):
    """Folder of a campaign with another search seed."""
    cover = ("--algorithm", "cover", "--evaluations", "100", "--seed", "2", "--no-explain")
    mrsfi("evolve", MISSION, *cover, *REFERENCE, "--out", "runs/second", cwd=place)
    return "runs/second"


@pytest.fixture
def told(place):
    return mrsfi_json("weaknesses", "runs/cover", cwd=place)


def test_every_witness_breaks_its_goal_and_no_part_of_it_does(place, told, monkeypatch):
    monkeypatch.chdir(place)
    mission = api.load(MISSION)
    goals = [goal.id for goal in mission.model.goals]
    witnesses = [
        tuple(TimedFault(**fault | {"values": tuple(fault["values"])}) for fault in one["witness"])
        for one in told
    ]
    parts = {
        witness: [witness[:k] + witness[k + 1 :] for k in range(len(witness))]
        for witness in witnesses
    }
    flights = [
        *dict.fromkeys([(), *witnesses, *(part for some in parts.values() for part in some)])
    ]
    found = zip(flights, mission.evaluate(flights, engine="reference", workers=1), strict=True)
    outcomes = dict(found)

    assert len(told) > 50
    for one, witness in zip(told, witnesses, strict=True):
        goal, margin = goals.index(one["goal"]), 0.05 * mission.model.duration
        fault_free, *counts = (
            getattr(outcomes[flown], one["measure"])[goal]
            for flown in ((), witness, *parts[witness])
        )
        most = fault_free + margin if fault_free else 0
        assert counts[0] > most >= max(counts[1:]), one
        assert one["faults"] == sorted(timed.fault for timed in witness)
        assert 0.0 < one["share"] <= 1.0
        depth = outcomes[witness].depths[goal]
        assert one["depth"] == (depth and {"value": depth[0], "tick": depth[1]})
    assert sum(one["depth"] is not None for one in told) > 10


def test_bounds_of_what_was_not_found_are_told_for_every_goal_and_measure(place, told, approved):
    bounds = mrsfi_json("weaknesses", "runs/cover", "--bounds", cwd=place)
    refused = mrsfi("weaknesses", "runs/cover", "--bounds", cwd=place, expected=2)

    approved(refused.stderr)
    assert len(bounds) == 7 * 3
    assert {(one["goal"], one["measure"]) for one in told} <= {
        (one["goal"], one["measure"]) for one in bounds
    }
    assert all((one["draws"] == 0) == (one["bound"] == 1.0) for one in bounds)
    assert min(one["bound"] for one in bounds) < 1.0


def test_in_more_mission_seeds_it_says_in_how_many_each_holds(place, told):
    again = mrsfi_json("weaknesses", "runs/cover", "--seeds", "3", *REFERENCE, cwd=place)

    held = [one["seeds"]["held"] for one in again]
    assert all(one["seeds"]["of"] == 3 for one in again)
    assert min(held) >= 1  # the campaign's own
    assert max(held) == 3
    of_one = {"seeds": {"held": 1, "of": 1}, "label": "of this seed"}
    assert [one | of_one for one in again] == told


def test_sentences_tell_of_as_many_mission_seeds_as_the_table(place, told):
    options = ("--seeds", "3", "--goal", told[0]["goal"], *REFERENCE)

    said = mrsfi("weaknesses", "runs/cover", *options, cwd=place).stdout

    (of_sentence,) = re.findall(r"weakness 1 .* in (\d) of 3 mission seeds", said)
    again = mrsfi_json("weaknesses", "runs/cover", *options, cwd=place)
    assert int(of_sentence) in {one["seeds"]["held"] for one in again if one["number"] == 1}
    assert "1 of 1" not in said


def test_it_ends_with_a_matrix_and_a_list_of_all_of_them(place, told, monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")

    said = mrsfi("weaknesses", "runs/cover", cwd=place).stdout

    truly = {one["goal"] for one in told if one["measure"] != "believed"}
    assert said.startswith("Six of seven goals break, each under a single fault\n")
    assert len(truly) == 6
    assert "…" not in said.replace(" … ", "").replace("(…)", "")
    words = {*said.split()}
    assert {one["goal"] for one in told} <= words
    guilty = {fault for one in told for fault in one["faults"]}
    assert guilty <= words
    assert guilty == {f"f{n}" for n in range(1, 31)}
    assert "Each of 30 faults is part of a known weakness\n" in said


def test_sets_that_were_not_tried_are_counted_from_the_record(place, told, monkeypatch):
    monkeypatch.chdir(place)
    mission = api.load(MISSION)

    said = mrsfi("weaknesses", "runs/cover", cwd=place).stdout

    counted = untried_by_hand(place / "runs" / "cover", mission.model, mission.pool, told)
    assert f"{counted} How many weaknesses there are" in " ".join(said.split())


def test_campaigns_of_other_search_seeds_estimate_how_many_there_are(place, second, told):
    cover = ("--algorithm", "cover", "--evaluations", "1", "--seed", "3", "--no-explain")
    options = ("--mission-seed", "2", *REFERENCE, "--out", "runs/other")
    mrsfi("evolve", MISSION, *cover, *options, cwd=place)

    def printed(*options, expected=0):
        found = mrsfi("weaknesses", "runs/cover", *options, cwd=place, expected=expected)
        return " ".join((found.stderr if expected else found.stdout).split())

    alone, both = printed(), printed("--with", second)
    options = ("runs/cover", "--with", second, "--bounds", "--goal", "energy")
    rows = mrsfi_json("weaknesses", *options, cwd=place)

    assert (
        f"mrsfi evolve {MISSION} … --seed 2, then mrsfi weaknesses runs/cover --with RUN2" in alone
    )
    assert [each["measure"] for each in rows] == ["believed", "true", "missed", None]
    found = rows[-1]["estimate"]
    low, high = found["interval"]
    of = f"Found {found['found']} weaknesses of energy in 2 campaigns; an estimated"
    assert f"{of} {found['estimated']:.0f} in all ({low} to {high}). runs/cover lacks" in both
    beside = mrsfi_json("weaknesses", second, "--goal", "energy", cwd=place)
    of_energy = [one for one in told if one["goal"] == "energy"]
    known, others = ({tuple(one["faults"]) for one in each} for each in (of_energy, beside))
    assert {*map(tuple, found["lacking"])} <= others - known
    for run, why in (
        ("cover", "search seed 1, as in"),
        ("other", "differs from runs/cover in mission seed"),
    ):
        refused = printed("--with", f"runs/{run}", expected=2)
        assert why in refused
        assert f"runs/{run}: " in refused
    assert "--bounds" in printed("--with", second, "--json", expected=2)


def test_risks_have_two_values_where_faults_have_likelihoods(place, second, tmp_path):
    for run in ("cover", second.removeprefix("runs/")):
        shutil.copytree(place / "runs" / run, tmp_path / run)
        pool = tmp_path / run / "model" / "faults.xmi"
        pool.write_text(pool.read_text().replace(' ID="f', ' likelihood="0.01" ID="f'))

    def risk(*others):
        options = ("cover", *others, "--goal", "energy")
        (row,) = (
            each
            for each in mrsfi_json("weaknesses", *options, "--bounds", cwd=tmp_path)
            if each["measure"] is None
        )
        return row["risk"], " ".join(mrsfi("weaknesses", *options, cwd=tmp_path).stdout.split())

    (alone, said_alone), (both, said) = risk(), risk("--with", "second")

    assert alone["upper"] is None
    assert 0.0 < alone["lower"] <= both["lower"] < both["upper"] < 1.0
    of = "Risk of energy: it is truly violated or fails in at least"
    least = f"{100 * alone['lower']:.2g} %"
    unless = "if no fault undoes another and variants break goals as often as those tried"
    assert f"{of} {least} of missions {unless}, a lower bound from" in said_alone
    assert f"this share of missions, {unless}: SufficientEnergy (energy) {least}" in said_alone
    assert said_alone.endswith("an upper value needs --with")
    assert f"{of} {100 * both['lower']:.2g} % of" in said
    assert f"sets; {100 * both['upper']:.2g} % if as many sets exist" in said
    summary = mrsfi_json("report", "cover", cwd=tmp_path)
    assert summary["weaknesses"]["risk"]["energy"] == alone


def test_one_goal_alone_is_told_and_one_that_there_is_not_is_refused(place, told):
    of_goal = mrsfi_json("weaknesses", "runs/cover", "--goal", "within", cwd=place)
    said = mrsfi("weaknesses", "runs/cover", "--goal", "within", cwd=place).stdout
    refused = mrsfi("weaknesses", "runs/cover", "--goal", "withn", cwd=place, expected=2)

    assert "Each of 30 faults is part of a known weakness" in said  # of any goal
    assert of_goal == [one for one in told if one["goal"] == "within"]
    assert "found 'withn'; expected one of" in refused.stderr
    assert "did you mean 'within'?" in refused.stderr


def test_a_column_that_a_record_lacks_prints_not_recorded(place, tmp_path):
    shutil.copytree(place / "runs" / "cover", tmp_path / "run")
    for column in ("margins", "detection"):
        execute(tmp_path / "run", f"ALTER TABLE evaluation DROP COLUMN {column}")

    printed = mrsfi("report", "run", cwd=tmp_path).stdout
    assert "Whether the CI detects it is not recorded" in " ".join(printed.split())
    mrsfi("replay", "run", "--engine", "reference", cwd=tmp_path)
    found = mrsfi_json("weaknesses", "run", cwd=tmp_path)
    assert {one["detection"] for one in found} == {None}
    assert {one["depth"] for one in found} == {None}


def test_failure_modes_are_titled_with_the_name_of_the_mission_as_commands_know_it(place, tmp_path):
    page = tmp_path / "fmea.md"

    mrsfi("weaknesses", "runs/cover", "--goal", "within", "--fmea", page, *REFERENCE, cwd=place)

    assert page.read_text().startswith(f"# Failure modes of mission {MISSION}\n\n| weakness | ")


def test_failure_modes_have_a_row_for_each_goal_and_set(place, told, tmp_path):
    table = tmp_path / "fmea.csv"

    mrsfi("weaknesses", "runs/cover", "--fmea", table, *REFERENCE, cwd=place)

    with table.open(encoding="utf-8", newline="") as file:
        rows = [*csv.DictReader(file)]
    sets = {(one["goal"], " ".join(one["faults"])) for one in told}
    goals = [each["end effect"].rpartition("(")[2].removesuffix(")") for each in rows]
    assert sorted(zip(goals, (each["faults"] for each in rows), strict=True)) == sorted(sets)
    worst = {(one["goal"], " ".join(one["faults"])): one["detection"] for one in told}
    assert {
        (goal, each["faults"]): each["detection"].startswith("The CI does not")
        for goal, each in zip(goals, rows, strict=True)
    } == {cell: found is not None and found["worst"] == "never" for cell, found in worst.items()}
    assert all(each["item"] and each["local effect"] and int(each["most ticks"]) for each in rows)
    assert {each["likelihood"] for each in rows} == {""}


def test_a_fault_tree_is_of_what_truly_happens(place, told, tmp_path):
    path = tmp_path / "trees.xml"

    mrsfi("weaknesses", "runs/cover", "--fault-tree", path, cwd=place)

    trees = {
        tree.get("name"): {each.get("name") for each in tree.iter("basic-event")}
        for tree in ET.parse(path).getroot().iter("define-fault-tree")
    }
    real = [one for one in told if one["measure"] != "believed"]
    assert {*trees} == {one["goal"] for one in real}
    alone = {(one["goal"], *one["faults"]) for one in real if len(one["faults"]) == 1}
    assert {(goal, fault) for goal, faults in trees.items() for fault in faults} >= alone


@pytest.mark.parametrize(
    "option",
    ["--fmea", "--fault-tree"],
)
@pytest.mark.parametrize("name", ["x.ods", "x"])
def test_a_file_of_another_kind_is_refused_with_those_that_there_are(
    place, tmp_path, option, name, approved
):
    refused = mrsfi("weaknesses", "runs/cover", option, tmp_path / name, cwd=place, expected=2)

    assert f"{name}: found" in refused.stderr
    approved(refused.stderr)
    assert not [*tmp_path.iterdir()]


def test_a_file_that_two_options_name_is_of_the_kind_of_both(place, tmp_path, approved):
    path = tmp_path / "x.xml"
    both = ("--fmea", path, "--fault-tree", path)

    refused = mrsfi("weaknesses", "runs/cover", *both, cwd=place, expected=2)

    approved(refused.stderr)
    assert not path.exists()
