"""Failure modes and fault trees: minimal sets, names, likelihoods, hostile text."""

import re
from dataclasses import replace

from lxml import etree

from mrsfi_runtime.analysis.failure_modes import (
    FailureMode,
    as_open_psa,
    as_pfta,
    modes_as_csv,
    modes_as_markdown,
)
from mrsfi_runtime.causes.mildest import goal_weaknesses
from mrsfi_runtime.causes.risk import cut_sets
from mrsfi_runtime.model.faults import FaultPool
from tests.support.search import PAPER_FAULTS, paper_mission, pool_of
from tests.support.weaknesses import weakness

FOUND = goal_weaknesses(
    [
        weakness("g2", "believed", "f7"),
        weakness("g2", "true", "f9"),
        weakness("g2", "true", "f3", "f5"),
        weakness("g2", "missed", "f9", "f11"),
        weakness("g2", "missed", "f5", "f3"),
        weakness("g3", "missed", "f9"),
    ]
)


def test_sets_are_least_over_truth_and_what_is_missed_and_belief_alone_is_none():
    assert cut_sets(FOUND, "g2") == [("f9",), ("f3", "f5")]
    assert cut_sets(FOUND, "g3") == [("f9",)]
    assert cut_sets(FOUND, "g1") == []


def test_open_psa_has_a_tree_for_each_goal_and_the_likelihoods_that_the_pool_gives():
    faults = (replace(each, likelihood=0.25) if each.id == "f5" else each for each in PAPER_FAULTS)
    pool = FaultPool("pool", tuple(faults))

    root = etree.fromstring(as_open_psa(paper_mission(), pool, FOUND))

    assert root.tag == "opsa-mef"
    tree, other = root.findall("define-fault-tree")
    assert (tree.get("name"), other.get("name")) == ("g2", "g3")
    top, joint = tree.findall("define-gate")
    assert _inputs(top.find("or")) == [("basic-event", "f9"), ("gate", "g2-f3-f5")]
    assert joint.get("name") == "g2-f3-f5"
    assert _inputs(joint.find("and")) == [("basic-event", "f3"), ("basic-event", "f5")]
    assert _inputs(other.find("define-gate"))[1:] == [("basic-event", "f9")]  # after the label
    events = root.findall("model-data/define-basic-event")
    assert [each.get("name") for each in events] == [
        fault.id for fault in pool if fault.id in {"f3", "f5", "f9"}
    ]
    floats = {each.get("name"): each.find("float") for each in events}
    assert floats.pop("f5").get("value") == "0.25"
    assert {*floats.values()} == {None}


def _inputs(formula):
    return [(each.tag, each.get("name")) for each in formula]


def test_labels_are_one_line_and_names_differ_whatever_ids_and_names_hold():
    mission = paper_mission()
    goals = [replace(each, name="a\n- type: NULL <b>&]]>\x85\u2028c") for each in mission.goals]
    goals[0] = replace(goals[0], id="F 9")
    first, second = (replace(each, name="=x\t\n") for each in PAPER_FAULTS[:2])
    pool = FaultPool("pool", (replace(first, id="f.9"), replace(second, id="f-9")))
    found = goal_weaknesses([weakness("F 9", "true", "f.9"), weakness("F 9", "true", "f-9")])
    hostile = replace(mission, goals=tuple(goals))

    text = as_pfta(hostile, pool, found).decode()
    root = etree.fromstring(as_open_psa(hostile, pool, found))

    lines = [line for line in text.splitlines() if line and not line.startswith("#")]
    assert all(re.fullmatch(r"(Gate|Event): [\w-]+|- \w+: \S.*", line) for line in lines)
    assert [line for line in lines if line[0] != "-"] == [
        "Gate: F_9",
        "Event: f_9-2",
        "Event: f_9-3",
    ]
    assert "- label: a - type: NULL <b>&]]> c (F 9): truly violated or failed" in lines
    names = [each.get("name") for each in root.iter("define-gate", "define-basic-event")]
    assert names == ["F_9", "f_9-2", "f_9-3"]


def test_without_anything_that_breaks_there_is_no_tree():
    root = etree.fromstring(as_open_psa(paper_mission(), pool_of(), FOUND[:1]))

    assert [each.tag for each in root.iterchildren("*")] == ["model-data"]
    assert "Gate" not in as_pfta(paper_mission(), pool_of(), FOUND[:1]).decode()


def test_no_cell_is_a_formula_in_a_spreadsheet_or_markup_on_a_page():
    texts = (7, "f9", "listed", "-a", "b|c", "<d", "=1+1 (g1)", "true", "no", "violated")
    modes = [FailureMode(*texts, 3, chance) for chance in (0.1 * 0.2, None)]

    table = modes_as_csv("harbour", modes).decode().splitlines()
    page = modes_as_markdown("har|bour", modes).decode().splitlines()

    assert table[0] == ",".join(FailureMode._fields)
    assert table[2] == "7,f9,listed,'-a,b|c,<d,'=1+1 (g1),true,no,violated,3,"
    assert page[0] == "# Failure modes of mission har\\|bour"
    told = "| 7 | f9 | listed | -a | b\\|c | &lt;d | =1+1 (g1) | true | no | violated | 3 | "
    assert page[-2:] == [f"{told}0.02 |", f"{told}– |"]
