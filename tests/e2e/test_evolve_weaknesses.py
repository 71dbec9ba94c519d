"""What ``mrsfi evolve`` finds out about weaknesses by itself, held to what other commands say."""

import json
import shutil
from pathlib import Path

import pytest

from mrsfi_runtime.generated_code import load_code
from tests.support.cli import edit, execute, mrsfi, mrsfi_json
from tests.support.interrupted import is_equal, rows
from tests.support.rendezvous import (
    N_SEARCHED,
    NAME,
    PLANTED,
    harmless,
    searched,
    write_planted,
)
from tests.support.weaknesses import untried_by_hand
from tests.tiers import slow

ONE = ("--workers", "1")


@pytest.fixture
def campaign(ended, tmp_path):
    """Copy of that campaign, at the same relative path, with the search that it names."""
    run, _ = ended
    for file in run.parents[1].glob("planted*"):
        shutil.copy(file, tmp_path)
    return Path(shutil.copytree(run, tmp_path / "runs" / "it")).relative_to(tmp_path)


def summary(run):
    return json.loads((run / "summary.json").read_text(encoding="utf-8"))


def found_in(run):
    return summary(run)["weaknesses"]["found"]


def test_it_ends_with_what_weaknesses_lists(ended):
    run, done = ended

    told = mrsfi_json("weaknesses", run, cwd=run.parent)

    found = found_in(run)
    rows = [
        {**{key: each.get(key) for key in told[0]}, "decision": "", "elsewhere": []}
        for each in found
    ]
    assert rows == told
    least = [each["mildest"] for each in found if each["mildest"]]
    report = (run / "report.md").read_text(encoding="utf-8")
    assert all(each["sentence"] in report for each in least)
    assert {each["goal"] for each in least} == {"g1", "g2", "g3"}
    sets = {(each["goal"], each["measure"], *each["faults"]) for each in told}
    assert sets >= {
        *((goal, kind, "stop_a") for goal in ("g1", "g3") for kind in ("believed", "true")),
        *((goal, kind, "stop_b") for goal in ("g2", "g3") for kind in ("believed", "true")),
    }
    assert all(len(each["faults"]) == 1 for each in told)
    assert all(each["seeds"]["held"] >= 4 and each["seeds"]["of"] == 5 for each in told)
    assert 0 < summary(run)["weaknesses"]["n_flown"] <= N_SEARCHED
    assert "All three goals fail, each under a single fault\n" in done.stdout
    assert "## All three goals fail, each under a single fault\n" in report
    for goal in ("g1", "g2", "g3"):
        (line,) = [line for line in done.stdout.split("\n") if line.startswith(f"{goal} fails if ")]
        assert f"- {line.partition('.')[0]}" in report
    assert done.stdout.endswith(f"next      mrsfi show runs/{run.name}\n")
    sentences = [sentence for each in found for sentence in each["sentences"]]
    assert sentences
    assert all(sentence in report for sentence in sentences)
    assert all("g2" not in each for each in sentences if "stop_a" in each)
    assert "harvest  " in done.stderr


def test_sets_that_neither_search_nor_harvest_tried_are_counted_from_the_record(found):
    run, code = found / "runs" / "it", load_code(found / "generated" / NAME)

    said = mrsfi("weaknesses", "runs/it", cwd=found).stdout

    told = mrsfi_json("weaknesses", "runs/it", cwd=found)
    counted = untried_by_hand(run, code.mission, code.pool, told)
    assert f"{counted} How many weaknesses there are" in " ".join(said.split())


def test_each_of_the_most_critical_names_the_weaknesses_that_it_has(ended):
    run, _ = ended
    numbers = {(each["goal"], *each["faults"]): each["number"] for each in found_in(run)}

    contained = {each["evaluation"]: {*each["weaknesses"]} for each in summary(run)["top"]}

    assert contained[0] == {
        numbers[each] for each in (("g1", "stop_a"), ("g3", "stop_a"), ("g3", "stop_b"))
    }
    assert contained[2] == {*numbers.values()} - {n for k, n in numbers.items() if "lie_a" in k}


def test_the_report_has_the_matrix_and_the_twin_of_figure_12(ended):
    run, _ = ended
    text = (run / "report.md").read_text(encoding="utf-8")

    for each in found_in(run):
        for sentence in each["sentences"]:
            assert f"\n- {sentence}" in text
    assert "| fault | type | g1 | g2 | g3 | target |" in text
    assert (run / "tables" / "figure_12_weaknesses.csv").is_file()
    assert "figure_12" not in text
    patterns = summary(run)["weaknesses"]["patterns"]
    counted = {pattern["type"]: pattern["n_occurrences"] for pattern in patterns}
    assert counted["StopRobot"] == 4


def test_a_report_says_the_same_again_but_for_what_only_a_flight_tells(ended, campaign, tmp_path):
    run, done = ended
    again = mrsfi("report", campaign, cwd=tmp_path)
    same = is_equal(tmp_path / campaign, run)
    text = (tmp_path / campaign / "report.md").read_text(encoding="utf-8")
    for code in (tmp_path / campaign / "generated").glob("*.py"):
        code.write_text("raise RuntimeError\n", encoding="utf-8")

    unflown = mrsfi("report", campaign, cwd=tmp_path)

    assert same
    assert "(figures/figure_12_weaknesses.png)" in text
    assert (tmp_path / campaign / "figures" / "figure_12_weaknesses.svg").is_file()
    assert again.stdout == done.stdout
    lines = [line for line in again.stdout.splitlines() if " at tick " not in line]
    assert list(filter(None, unflown.stdout.splitlines())) == list(filter(None, lines))


def test_a_written_witness_flown_again_breaks_what_was_printed(ended):
    run, _ = ended

    for each in found_in(run):
        path = run / "weaknesses" / f"{each['number']:02d}.xmi"
        flight = mrsfi_json("simulate", NAME, "--faults", path, cwd=run.parents[1])
        (goal,) = [goal for goal in flight["goals"] if goal["id"] == each["goal"]]
        assert goal[each["measure"]] > 0


def test_too_few_flights_for_any_leave_the_ten_most_critical(small):
    evolve = write_planted(small, PLANTED)

    done = mrsfi(*evolve, *ONE, "--out", "out", cwd=small)

    assert done.stdout.startswith("The 4 most critical of 4 fault specifications\n")
    assert found_in(small / "out") == []
    shown = mrsfi("show", "out", cwd=small).stdout
    assert shown.startswith("Three of three goals were violated in the search, but the flights ")
    assert mrsfi("show", "out", "1", cwd=small, expected=2).stderr.endswith("none was found\n")


@slow
def test_no_explain_leaves_it_out_and_resume_looks_for_it_where_asked(ended, small):
    run, done = ended

    without = mrsfi(*searched(small), *ONE, "--no-explain", "--out", "runs/it", cwd=small)
    found = summary(small / "runs" / "it")
    refused = mrsfi("weaknesses", "runs/it", cwd=small, expected=9)
    as_begun = mrsfi("evolve", "--resume", "runs/it", cwd=small)
    resumed = mrsfi("evolve", "--resume", "runs/it", "--explain", cwd=small)
    again = mrsfi("evolve", "--resume", "runs/it", cwd=small)

    assert without.stdout.startswith("The 10 most critical of 130 fault specifications\n")
    assert "harvest" not in without.stderr
    assert found["weaknesses"] is None
    assert "run mrsfi explain runs/it --all" in refused.stderr
    assert "was finished already" in as_begun.stderr
    assert as_begun.stdout == without.stdout
    assert "was finished already" not in resumed.stderr
    assert resumed.stdout == again.stdout == done.stdout
    assert is_equal(small / "runs" / "it", run)


@slow
def test_explain_all_looks_for_what_was_left_out(ended, campaign, tmp_path):
    run, _ = ended
    execute(tmp_path / campaign, "DELETE FROM flight")

    before = mrsfi_json("report", campaign, cwd=tmp_path)
    explained = mrsfi("explain", campaign, "--all", "--engine", "reference", cwd=tmp_path)

    assert before["weaknesses"] is None
    listed = mrsfi("weaknesses", run, cwd=run.parent).stdout.replace(str(run), str(campaign))
    assert explained.stdout.split() == listed.split()  # a longer path wraps elsewhere
    assert rows(tmp_path / campaign) == rows(run)


def test_what_the_search_never_broke_is_found_all_the_same(small):
    evolve = write_planted(small, harmless(60))

    mrsfi(*evolve, *ONE, "--out", "out", cwd=small)

    assert {each["goal"] for each in found_in(small / "out")} == {"g1", "g2", "g3"}


def test_a_region_that_fails_under_some_of_the_faults_leaves_the_other_weaknesses(small):
    code = small / "generated" / NAME / "collective_intelligence.py"
    edit(
        code,
        "return goal_tasks.visit.violated(ci, G3)",
        "a, b = ci.robots\n"
        "    if ci.mission.tick == 60 and a.x < -50.0 and b.x < 50.0:\n"
        "        raise ArithmeticError('a alone is late')\n"
        "    return goal_tasks.visit.violated(ci, G3)",
    )
    evolve = write_planted(small, [[("stop_b", 20, 119)], *harmless(100)])

    mrsfi(*evolve, *ONE, "--out", "out", cwd=small)

    assert any("a alone is late" in found for *_, found in rows(small / "out"))
    assert ["stop_b"] in [each["faults"] for each in found_in(small / "out")]


@slow
def test_a_fitness_of_ones_own_plays_no_part_in_causes_and_explain_says_so(small):
    evolve = write_planted(small, PLANTED, fitness="planted_search:truly_violated")

    mrsfi(*evolve, *ONE, "--no-explain", "--out", "out", cwd=small)
    told = mrsfi("explain", "out", "--engine", "reference", "--measure", "true", cwd=small)

    assert (
        "fitness planted_search:truly_violated is not used: causes are found for true violations\n"
        in told.stderr
    )


@pytest.mark.parametrize("algorithm", ["paper", "cover"])
def test_the_faults_of_protected_elements_are_left_out_of_search_and_results(small, algorithm):
    words = ("evolve", NAME, *ONE, "--engine", "reference", "--algorithm", algorithm)
    short = ("--evaluations", "30", "--faults", "2", "--out", "out")
    case = small / "empty.toml"
    case.write_text("[search]\n", encoding="utf-8")

    done = mrsfi(*words, *short, "--case", case, "--protect", "a", cwd=small)
    again = mrsfi("evolve", "--resume", "out", *ONE, "--engine", "reference", cwd=small)

    assert "left out: 2 of 3 faults, which strike or touch a\n" in done.stderr
    assert again.stdout == done.stdout
    assert "Protect first: b: all 2 weaknesses\n" in done.stdout
    assert (
        "\nNot tried yet for at least one goal: 0 of 1 fault\n"
        in mrsfi("weaknesses", "out", cwd=small).stdout
    )
    told = summary(small / "out")
    assert told["settings"]["protect"] == ["a"]
    assert {fault for each in found_in(small / "out") for fault in each["faults"]} == {"stop_b"}
    assert told["weaknesses"]["protect"] == [
        {"element": "b", "faults": ["stop_b"], "closes": [1, 2], "gone": [1, 2]}
    ]
    assert not any("stop_a" in str(row) or "lie_a" in str(row) for row in rows(small / "out"))


@pytest.mark.parametrize(
    ("protect", "found"),
    [
        ("c", "option protect: found 'c'; expected one of a, b, report"),
        ("a,b", "option protect: found a, b, which leaves out all of 3 faults"),
    ],
)
def test_elements_that_are_unknown_or_have_all_faults_are_refused(small, protect, found):
    evolve = write_planted(small, PLANTED)

    refused = mrsfi(*evolve, "--protect", protect, "--out", "out", cwd=small, expected=2)

    assert found in refused.stderr
    assert not (small / "out").exists()
