"""What ``mrsfi evolve`` finds out about causes by itself, held to what other commands fly."""

import csv
import json
import os
import re
import shutil
import sqlite3
from contextlib import closing
from pathlib import Path
from signal import SIGKILL, SIGTERM

import pytest

from tests.support.cli import disturbed, edit, interrupted, mrsfi, mrsfi_json
from tests.support.processes import children
from tests.support.rendezvous import NAME, PLANTED, harmless, write_planted, write_rendezvous
from tests.tiers import seeds, slow

TOO_MUCH = "it would take more flights than the search did"
NOTHING = "it violates no goal that is counted"
N_SEARCHED = 130
"""Evaluations of the search: more than all four causes take."""

ONE = ("--workers", "1")


@pytest.fixture
def place(tmp_path):
    """Folder with models and generated code of the mission, and none of campaigns."""
    write_rendezvous(tmp_path)
    return tmp_path


@pytest.fixture(scope="module")
def ended(tmp_path_factory):
    """Folder of a campaign that was explained, and what the command printed."""
    folder = tmp_path_factory.mktemp("ended")
    write_rendezvous(folder)
    evolve = write_planted(folder, [*PLANTED, *harmless(N_SEARCHED - len(PLANTED))])
    done = mrsfi(*evolve, *ONE, "--out", "runs/it", cwd=folder)
    return folder / "runs" / "it", done


@pytest.fixture
def campaign(ended, tmp_path):
    """Copy of that campaign, at the same relative path, with the search that it names."""
    run, _ = ended
    for file in run.parents[1].glob("planted*"):
        shutil.copy(file, tmp_path)
    return Path(shutil.copytree(run, tmp_path / "runs" / "it")).relative_to(tmp_path)


def summary(run):
    return json.loads((run / "summary.json").read_text(encoding="utf-8"))


def rows(run):
    """Return the table of causes, as it is stored."""
    with closing(sqlite3.connect(run / "campaign.sqlite")) as record:
        return record.execute("SELECT * FROM cause ORDER BY idx").fetchall()


def execute(run, statement):
    with closing(sqlite3.connect(run / "campaign.sqlite")) as record, record:
        record.execute(statement)


def is_equal(run, other):
    """Return whether two campaigns keep and say the same of causes; not all draw their flights."""
    figure = "tables/figure_12_cause_sets.csv"
    files = ("summary.json", "critical/01-cause.xmi", figure)
    reports = [(each / "report.md").read_text(encoding="utf-8") for each in (run, other)]
    one, another = (re.sub(r"!\[Finding .*\n\n", "", report) for report in reports)
    return (rows(run), one) == (rows(other), another) and all(
        (run / name).read_bytes() == (other / name).read_bytes() for name in files
    )


@slow
def test_it_ends_with_what_explain_says_of_the_same_evaluations(ended):
    run, done = ended
    causes = summary(run)["causes"]

    told = mrsfi_json(
        *("explain", run, "--top", "10", "--engine", "reference", "--out", "causes"),
        cwd=run.parent,
    )

    assert causes["findings"] == told["findings"]
    assert [finding["evaluations"] for finding in causes["findings"]] == [[2, 3], [0], [1]]
    by_leader = {
        finding["evaluations"][0]: [fault["id"] for fault in finding["cause_set"]]
        for finding in causes["findings"]
    }
    assert by_leader == {
        2: ["stop_a.1", "stop_b.1"],
        0: ["stop_a.1"],
        1: ["stop_a.1", "stop_a.2"],
    }
    sets = {
        int(each["specification"].split()[1]): each["cause_set"]["faults"]
        for each in told["explanations"]
        if each["is_violated"]
    }
    assert {index: sets[index] for index in by_leader} == by_leader
    assert causes["n_explained"] == 4
    assert [each["reason"] for each in causes["not_explained"]] == [NOTHING] * 6
    assert causes["n_flown"] <= N_SEARCHED
    for finding in causes["findings"]:
        assert finding["sentence"] in done.stdout
        (leading,) = [
            fault for fault in finding["cause_set"] if finding["sentence"].startswith(fault["id"])
        ]
        assert finding["sentence"].startswith(leading["sentence"])
    assert "3 findings in 4 specifications\n" in done.stdout
    assert "evaluation 4 is not explained: it violates no goal that is counted\n" in done.stdout
    assert "cause 10/10 " in done.stderr


def test_the_report_has_findings_and_the_twin_of_figure_12(ended):
    run, _ = ended
    text = (run / "report.md").read_text(encoding="utf-8")

    for finding in summary(run)["causes"]["findings"]:
        for fault in finding["cause_set"]:
            assert f"\n- {fault['sentence']}" in text
    assert "Of the 10 most critical specifications 4 are explained" in text
    assert "| [1](critical/01-cause.xmi) | 2 3 | stop_a.1 stop_b.1 | 50/50 " in text
    assert "- evaluation 4 is not explained: it violates no goal that is counted\n" in text
    for kind in ("figures/{}.png", "figures/{}.svg", "tables/{}.csv"):
        assert (run / kind.format("figure_12_cause_sets")).stat().st_size > 0
    assert "(figures/figure_12_cause_sets.png)" in text or "figure_12_cause_sets.svg" in text
    patterns = summary(run)["causes"]["patterns"]
    counted = {pattern["type"]: pattern["n_occurrences"] for pattern in patterns}
    assert counted["StopRobot"] == 2 + 2 + 1 + 2
    assert not counted["FixedRobotCoordinates"]


def test_a_report_prints_the_findings_again_without_flying(ended, campaign, tmp_path):
    run, done = ended
    for code in (tmp_path / campaign / "generated").glob("*.py"):
        code.write_text("raise RuntimeError\n", encoding="utf-8")

    again = mrsfi("report", campaign, cwd=tmp_path)

    assert again.stdout == done.stdout
    assert is_equal(tmp_path / campaign, run)
    assert not [*(tmp_path / campaign / "figures").glob("finding_*")]
    assert "(figures/finding_" not in (tmp_path / campaign / "report.md").read_text()


def test_every_finding_has_its_figures_and_their_numbers(ended):
    run, _ = ended
    text = (run / "report.md").read_text(encoding="utf-8")
    findings = summary(run)["causes"]["findings"]
    names = [
        f"finding_{k:02d}_{what}"
        for k in range(1, len(findings) + 1)
        for what in ("map", "timeline")
    ]

    for folder, suffix in (("figures", "png"), ("figures", "svg"), ("tables", "csv")):
        found = sorted(path.stem for path in (run / folder).glob(f"finding_*.{suffix}"))
        assert found == names
    assert all(f"(figures/{name}.png)" in text for name in names)
    for k, finding in enumerate(findings, 1):
        with (run / "tables" / f"finding_{k:02d}_timeline.csv").open(encoding="utf-8") as file:
            windows = list(csv.DictReader(file))
        faults = [row["name"] for row in windows if row["kind"] == "fault"]
        assert faults == [fault["id"] for fault in finding["cause_set"]]
        for goal, ticks in finding["true"].items():
            assert ticks == sum(
                int(row["last"]) - int(row["first"]) + 1
                for row in windows
                if (row["name"], row["what"]) == (goal, "truly violated")
            )


def test_a_written_cause_set_flown_again_has_the_counts_that_were_printed(ended):
    run, _ = ended
    found = summary(run)
    ranks = [each["evaluation"] for each in found["top"]]
    written = {
        ranks[int(path.stem.removesuffix("-cause")) - 1]: path
        for path in (run / "critical").glob("*-cause.xmi")
    }

    assert sorted(written) == [0, 1, 2, 3]
    for finding in found["causes"]["findings"]:
        path = written[finding["evaluations"][0]]
        flight = mrsfi_json("simulate", NAME, "--faults", path, cwd=run.parents[1])
        for kind in ("believed", "true", "missed", "missed_since"):
            assert finding[kind] == {goal["id"]: goal[kind] for goal in flight["goals"]}
        names = [fault["id"] for fault in flight["faults"]]
        assert names == [fault["id"] for fault in finding["cause_set"]]
        whole = path.with_name(path.name.replace("-cause", ""))
        flight = mrsfi_json("simulate", NAME, "--faults", whole, cwd=run.parents[1])
        assert set(names) <= {fault["id"] for fault in flight["faults"]}


@slow
@pytest.mark.parametrize("n_seeds", seeds([1, 2], 1))
def test_it_flies_at_most_as_often_as_the_search_did(place, n_seeds):
    searched = [*PLANTED, *harmless(60 - len(PLANTED))]
    evolve = write_planted(place, searched, replications=n_seeds)

    found = mrsfi_json(*evolve, *ONE, "--out", "out", cwd=place)

    causes = found["causes"]
    assert found["n_evaluations"] == 60
    assert 0 < causes["n_flown"] <= 60 * n_seeds
    assert 1 <= causes["n_explained"] < len(PLANTED)
    ranked = [each["evaluation"] for each in found["top"]]
    first = ranked[causes["n_explained"]]
    assert causes["not_explained"] == [{"evaluation": first, "reason": TOO_MUCH}]
    assert len(rows(place / "out")) == causes["n_explained"] + 1
    told = mrsfi("report", "out", cwd=place).stdout
    assert f"\nevaluation {first} is not explained: {TOO_MUCH}\n" in told


@slow
def test_too_few_flights_for_any_leave_the_ten_most_critical(place):
    evolve = write_planted(place, PLANTED)

    done = mrsfi(*evolve, *ONE, "--out", "out", cwd=place)

    assert done.stdout.startswith("The 4 most critical of 4 fault specifications\n")
    assert f"evaluation 2 is not explained: {TOO_MUCH}\n" in done.stdout
    text = (place / "out" / "report.md").read_text(encoding="utf-8")
    assert "Of the 4 most critical specifications 0 are explained" in text
    assert f"- evaluation 2 is not explained: {TOO_MUCH}\n" in text
    assert not [*(place / "out" / "critical").glob("*-cause.xmi")]


@slow
def test_no_explain_leaves_it_out_and_resume_goes_on_with_it(ended, place):
    run, done = ended
    evolve = write_planted(place, [*PLANTED, *harmless(N_SEARCHED - len(PLANTED))])

    without = mrsfi(*evolve, *ONE, "--no-explain", "--out", "runs/it", cwd=place)
    found = summary(place / "runs" / "it")
    resumed = mrsfi("evolve", "--resume", "runs/it", cwd=place)

    assert without.stdout.startswith("The 10 most critical of 130 fault specifications\n")
    assert "cause " not in without.stderr
    assert found["causes"] is None
    assert "was finished already" not in resumed.stderr
    assert resumed.stdout == done.stdout
    assert is_equal(place / "runs" / "it", run)


@slow
@pytest.mark.parametrize("sign", ["SIGKILL", "SIGINT"])
def test_a_run_that_is_ended_while_it_explains_goes_on_to_the_same(ended, place, sign):
    run, done = ended
    evolve = write_planted(place, [*PLANTED, *harmless(N_SEARCHED - len(PLANTED))])
    out = place / "runs" / "it"
    words = (*evolve, *ONE, "--out", "runs/it")
    if sign == "SIGKILL":
        cut = disturbed(*words, cwd=place, sign="cause  1/10", disturb=kill)
    else:
        cut = interrupted(*words, cwd=place, sign="cause  1/10")
    kept = rows(out)

    resumed = mrsfi("evolve", "--resume", "runs/it", *ONE, cwd=place)
    again = mrsfi("evolve", "--resume", "runs/it", *ONE, cwd=place)

    assert cut.returncode == (-SIGKILL if sign == "SIGKILL" else 130), cut.stderr
    assert 1 <= len(kept) < 10
    assert {*kept} < {*rows(run)}
    assert f"cause {len(kept) + 1:>2}/10" in resumed.stderr
    assert f"cause {len(kept):>2}/10" not in resumed.stderr
    assert resumed.stdout == again.stdout == done.stdout
    assert "was finished already" in again.stderr
    assert "cause " not in again.stderr
    assert is_equal(out, run)


def kill(process):

    os.kill(process, SIGKILL)


@slow
def test_a_worker_that_is_lost_is_no_reason_why_something_has_no_cause(ended, place):
    run, done = ended
    evolve = write_planted(place, [*PLANTED, *harmless(N_SEARCHED - len(PLANTED))])
    words = (*evolve, "--workers", "2", "--out", "runs/it")

    cut = disturbed(*words, cwd=place, sign="cause  1/10", disturb=end_a_worker)
    kept = rows(place / "runs" / "it")
    resumed = mrsfi("evolve", "--resume", "runs/it", *ONE, cwd=place)

    assert cut.returncode == 6, cut.stderr
    assert "a worker process died; resume the campaign" in cut.stderr
    assert "go on with: mrsfi evolve --resume runs/it" in cut.stderr
    assert {*kept} < {*rows(run)}
    assert resumed.stdout == done.stdout


def end_a_worker(process):

    os.kill(children(process, b"spawn_main")[0], SIGTERM)


@slow
def test_a_campaign_that_was_begun_before_there_were_causes_is_explained(ended, campaign, tmp_path):
    run, done = ended
    execute(tmp_path / campaign, "DROP TABLE cause")

    before = mrsfi_json("report", campaign, cwd=tmp_path)
    resumed = mrsfi("evolve", "--resume", campaign, *ONE, cwd=tmp_path)

    assert before["causes"] is None
    assert resumed.stdout == done.stdout
    assert is_equal(tmp_path / campaign, run)


@pytest.mark.parametrize("command", seeds([("report",), ("evolve", "--resume")], 1))
def test_damaged_causes_end_with_9_like_other_damage(campaign, tmp_path, command):
    execute(tmp_path / campaign, "UPDATE cause SET content = replace(content, 'places', 'place')")

    error = mrsfi(*command, campaign, cwd=tmp_path, expected=9).stderr

    assert f"{campaign}/campaign.sqlite: the record is damaged: found " in error
    assert "expected a cause set of the 2 faults of evaluation 0" in error


@slow
@pytest.mark.parametrize(
    "options",
    [
        ("--workers", "2"),
        pytest.param(("--dask", "local", "--workers", "2"), marks=slow),
        pytest.param(("--engine", "compiled", "--workers", "1"), marks=slow),
        pytest.param(("--engine", "compiled", "--workers", "2"), marks=slow),
        pytest.param(("--engine", "rosbridge", "--workers", "2"), marks=slow),
    ],
    ids=" ".join,
)
def test_whoever_flies_the_causes_are_the_same(ended, campaign, tmp_path, options):
    run, done = ended
    execute(tmp_path / campaign, "DELETE FROM cause")

    flown = mrsfi("evolve", "--resume", campaign, *options, cwd=tmp_path)

    assert flown.stdout == done.stdout
    assert is_equal(tmp_path / campaign, run)


def test_a_search_that_violates_nothing_has_no_findings(place):
    evolve = write_planted(place, harmless(20))

    done = mrsfi(*evolve, *ONE, "--out", "out", cwd=place)

    causes = summary(place / "out")["causes"]
    assert done.stdout.startswith("The 10 most critical of 20 fault specifications\n")
    assert done.stdout.count(f" is not explained: {NOTHING}\n") == 10
    assert causes["findings"] == []
    assert causes["n_explained"] == 0
    assert len(causes["not_explained"]) == 10
    text = (place / "out" / "report.md").read_text(encoding="utf-8")
    assert text.count(f" is not explained: {NOTHING}\n") == 10
    assert not [*(place / "out" / "figures").glob("*cause_sets*")]


def test_a_region_that_fails_under_some_of_the_faults_is_told_and_the_rest_is_explained(place):
    code = place / "generated" / NAME / "collective_intelligence.py"
    edit(
        code,
        "return goal_tasks.visit.violated(ci, G3)",
        "a, b = ci.robots\n"
        "    if ci.mission.tick == 60 and a.x < -50.0 and b.x < 50.0:\n"
        "        raise ArithmeticError('a alone is late')\n"
        "    return goal_tasks.visit.violated(ci, G3)",
    )
    both, other = [("stop_b", 10, 119), ("stop_a", 10, 119)], [("stop_b", 20, 119)]
    evolve = write_planted(place, [both, other, *harmless(100)])

    done = mrsfi(*evolve, *ONE, "--out", "out", cwd=place)

    found = summary(place / "out")
    (failed,) = [each for each in found["causes"]["not_explained"] if each["reason"] != NOTHING]
    assert failed["evaluation"] == 0
    assert "collective_intelligence.py:" in failed["reason"]
    assert "a alone is late" in failed["reason"]
    assert failed["reason"].endswith("(flown with the faults stop_a 10 … 119)")
    assert f"evaluation 0 is not explained: {failed['reason']}\n" in done.stdout
    assert [each["evaluations"] for each in found["causes"]["findings"]] == [[1]]
    assert "1 finding in 1 specification\n" in done.stdout


@slow
def test_what_fails_without_any_fault_is_not_due_to_faults(place):
    edit(
        place / "generated" / NAME / "collective_intelligence.py",
        "return goal_tasks.visit.violated(ci, G3)",
        "return ci.mission.tick > 90",
    )
    evolve = write_planted(place, [[("stop_b", 20, 119)], *harmless(40)], goals=["g3"])

    done = mrsfi(*evolve, *ONE, "--out", "out", cwd=place)

    reason = "without any of its faults, the violations are there as well"
    assert f" is not explained: {reason}\n" in done.stdout


@slow
def test_a_fitness_of_ones_own_plays_no_part_and_both_commands_say_so(place):
    words = (
        "fitness planted_search:truly_violated plays no part: "
        "causes are about believed violations\n"
    )
    evolve = write_planted(
        place, [*PLANTED, *harmless(100)], fitness="planted_search:truly_violated"
    )

    done = mrsfi(*evolve, *ONE, "--out", "out", cwd=place)
    told = mrsfi("explain", "out", "--engine", "reference", "--measure", "true", cwd=place)

    assert words in done.stderr
    assert words.replace("believed", "true") in told.stderr
    assert "findings in " in done.stdout
