"""Monitors are recommended in words, and their sums recounted from the cases in JSON."""

import csv
import json
import math
import shutil
from collections import defaultdict
from difflib import unified_diff
from operator import itemgetter

import pytest

from mrsfi_runtime.engine.flights import ReferenceEngine
from mrsfi_runtime.generated_code import load_code
from mrsfi_runtime.model.faults import TimedFault
from tests.support.cli import edit, execute, mrsfi, mrsfi_json, mrsfi_process
from tests.support.edited import COLLECTIVE
from tests.support.pages import blocks
from tests.support.report_page import data_of
from tests.support.tree import ROOT

RUN = ("runs/it", "--engine", "reference")
STAGES = ("in time", "before the goal fails", "later", "never")
NAMES = ("in_time", "before_failure", "later", "never")


def stage(case, names):
    """Return when a case is detected, by the belief or by a monitor."""
    ticks = [tick for name in names for tick in case["alarms"].get(name, {}).values()]
    ticks += [] if case["believed"] is None else [case["believed"]]
    failed = math.inf if case["failed"] is None else case["failed"]
    if not ticks:
        return STAGES[3]
    first = min(ticks)
    return STAGES[0 if first <= case["broken"] else 1 if first < failed else 2]


def shares(cases, names):
    """Return the share of the weight of each stage."""
    weights = defaultdict(float)
    for case in cases:
        weights[stage(case, names)] += case["weight"]
    total = sum(weights.values())
    return [weights[name] / total for name in STAGES]


def test_it_says_what_to_add_and_what_remains(found, approved):
    printed = mrsfi("monitors", *RUN, "--fit-seeds", "5", cwd=found)

    approved(printed.stdout)


def test_each_step_is_the_best_and_the_last_leaves_no_gain(found):
    told = mrsfi_json("monitors", *RUN, cwd=found)

    cases, names = told["cases"], []
    assert [told["belief"][name] for name in NAMES] == pytest.approx(shares(cases, names))
    for step in told["recommended"]:
        names.append(step["monitor"])
        after = shares(cases, names)
        assert [step["coverage"][name] for name in NAMES] == pytest.approx(after)
        others = ([*names[:-1], name] for name in told["thresholds"])
        assert after[0] >= max(shares(cases, some)[0] for some in others)
    assert all(case["stage"] == stage(case, names) for case in cases)
    for name in told["thresholds"]:
        assert shares(cases, [*names, name]) == shares(cases, names)
    assert len(names) == len({*names}) > 0


def test_weights_of_a_weakness_sum_up_to_its_share(found):
    """Here, the variants that violate a goal are among those that make it fail, or vice versa."""
    listed, weights = defaultdict(list), defaultdict(float)
    for row in mrsfi_json("weaknesses", "runs/it", cwd=found):
        if row["measure"] != "believed":
            listed[row["number"]].append(row["share"])
    for case in mrsfi_json("monitors", *RUN, "--fit-seeds", "1", cwd=found)["cases"]:
        weights[case["weakness"]] += case["weight"]

    assert weights == pytest.approx({number: max(some) for number, some in listed.items()})


@pytest.fixture
def project(found, tmp_path):
    """Copy of the mission with its campaign."""
    return shutil.copytree(found, tmp_path / "project")


def collective(project):
    """Return the file with the regions of the goals."""
    (path,) = (project / "generated").glob(f"*/{COLLECTIVE}")
    return path


def test_written_monitors_fly_and_a_reaction_of_the_team_is_kept(project, approved):
    before, path = collective(project).read_text(), collective(project)

    mrsfi("monitors", *RUN, "--write", cwd=project)
    written = path.read_text()
    edit(path, "commands.set_speed(ci, k, 0.0)", "commands.set_speed(ci, k, 0.5)")
    edited = path.read_text()
    mrsfi("monitors", *RUN, "--write", cwd=project)

    approved("".join(unified_diff(before.splitlines(True), written.splitlines(True), n=0)))
    assert path.read_text() == edited != written
    moved = edited.replace("    check_monitors(ci)\n", "")  # as if another goal had been the first
    last = moved.rindex("    # protected region", 0, moved.rindex(".react end"))
    path.write_text(f"{moved[:last]}    check_monitors(ci)\n{moved[last:]}")
    mrsfi("monitors", *RUN, "--write", cwd=project)
    assert path.read_text() == edited
    assert "0 warnings" in mrsfi("validate", path.parent.name, cwd=project).stdout
    assert mrsfi("generate", path.parent.name, "--check", cwd=project)
    digests = {
        mrsfi_json("simulate", path.parent.name, "--engine", engine, cwd=project)["digest"]
        for engine in ("reference", "compiled")
    }
    assert len(digests) == 1


def test_monitors_are_not_written_for_another_mission(project):
    path = collective(project)
    edit(project / "models" / path.parent.name / "mission.xmi", 'speed="4.0"', 'speed="4.5"')
    mrsfi("generate", path.parent.name, cwd=project)
    before = path.read_text()

    refused = mrsfi("monitors", *RUN, "--fit-seeds", "1", "--write", cwd=project, expected=2)

    assert "differs from the mission of runs/it" in refused.stderr
    assert path.read_text() == before


PAGE = ROOT / "docs" / "monitors.md"
(OWN,) = ("\n".join(each.lines) for each in blocks(PAGE.read_text()) if each.kind == "python")
"""The file monitors.py of the page."""


def test_a_project_has_monitors_of_its_own(project):
    (project / "monitors.py").write_text(OWN)

    printed = mrsfi_process("monitors", *RUN, "--fit-seeds", "2", "--json", cwd=project)
    listed = json.loads(printed.stdout)

    assert listed["thresholds"]["lag"] == pytest.approx({"a": 1e-6, "b": 1e-6})
    assert any("lag" in case["alarms"] for case in listed["cases"])


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('"lag"', '"map"', "found 'map' in MONITORS; expected a tuple of Monitor"),
        ("    return max(", "    if ci.robots[r].x > 0.0:\n        return 0.0\n    return max(",
         "monitors.py:7: ValueError: The truth value of an array"),
        ("MONITORS", "OTHERS", "found None in MONITORS"),
    ],
)  # fmt: skip
def test_a_defect_of_such_monitors_is_reported_with_its_place(project, old, new, words):
    (project / "monitors.py").write_text(OWN.replace(old, new))

    refused = mrsfi_process("monitors", *RUN, "--fit-seeds", "1", cwd=project, expected=2)

    assert words in refused.stderr


def test_the_campaign_keeps_what_to_add_for_its_page_and_its_fmea(project):
    run = project / "runs" / "it"
    listed = mrsfi_json("monitors", *RUN, cwd=project)
    names = [step["monitor"] for step in listed["recommended"]]
    in_time = defaultdict(list)
    for case in listed["cases"]:
        in_time[case["weakness"]].append(stage(case, names) == STAGES[0])

    printed = mrsfi("weaknesses", "runs/it", "--fmea", "fmea.csv", cwd=project).stdout
    mrsfi("report", "runs/it", cwd=project)

    assert f"Monitor first: {names[0]} of " in " ".join(printed.split())
    table = data_of(run / "report.html")["first"]["monitors"]["rows"]
    assert [row[0] for row in table] == names
    with (project / "fmea.csv").open() as file:
        rows = {int(row["weakness"]): row for row in csv.DictReader(file)}
    for number, each in in_time.items():
        counts = f"in time in {sum(each)} of {len(each)} in the first mission seed"
        assert rows[number]["detection"].endswith(counts)
        helps = any(
            stage(case, names) != stage(case, [])
            for case in listed["cases"]
            if case["weakness"] == number
        )
        assert bool(rows[number]["recommended action"]) == helps
    execute(run, "UPDATE meta SET value = json_set(value, '$[0]', 1) WHERE key = 'monitors'")
    assert "Monitor first" not in mrsfi("weaknesses", "runs/it", cwd=project).stdout


def test_written_monitors_react_at_the_tick_of_the_alarm_that_was_found(project):
    """The default reaction commands speed 0, so flights are the same until a robot should move."""
    listed = mrsfi_json("monitors", *RUN, cwd=project)
    names = [step["monitor"] for step in listed["recommended"]]
    folder = collective(project).parent
    shutil.copytree(folder, project / "before" / folder.name)
    mrsfi("monitors", *RUN, "--write", cwd=project)
    n_reactions = 0

    codes = [load_code(place) for place in (project / "before" / folder.name, folder)]
    engines = [ReferenceEngine(code, 1) for code in codes]
    for case in listed["cases"]:
        variant = tuple(
            TimedFault(each["fault"], each["start"], each["finish"], tuple(each["values"]))
            for each in case["variant"]
        )
        before, after = (
            engine.record(variant)["belief"]["commands"]["speed"] for engine in engines
        )
        differing = (before != after).any(axis=1)
        raised = [case["alarms"].get(name, {}) for name in names]
        ticks = {robot: tick for each in raised for robot, tick in each.items()}
        if ticks:
            robot, tick = min(ticks.items(), key=itemgetter(1))
            assert not differing[:tick].any(), case
            k = codes[0].mission.robot_index[robot]
            assert differing[tick] == (before[tick, k] > 0.0), case
            n_reactions += bool(differing[tick])
        else:
            assert not differing.any(), case

    assert n_reactions > 0
