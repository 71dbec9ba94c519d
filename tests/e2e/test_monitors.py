"""Monitors are recommended in words, and their sums recounted from the cases in JSON."""

import math
import shutil
from collections import defaultdict

import pytest

from tests.support.cli import execute, mrsfi, mrsfi_json

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


def test_a_campaign_in_an_external_world_is_refused(found, tmp_path):
    run = shutil.copytree(found / "runs" / "it", tmp_path / "runs" / "it")
    bus = """'$.engine', 'rosbridge', '$.bus', json('{"side": "ci", "url": "ws://127.0.0.1:9"}')"""
    value = f"json_set(value, {bus})"
    execute(run, f"UPDATE meta SET value = {value} WHERE key = 'manifest'")

    refused = mrsfi("monitors", "runs/it", cwd=tmp_path, expected=2)

    assert refused.stderr == (
        "mrsfi: runs/it: was flown with --side ci; expected mrsfi's own world\n"
    )
