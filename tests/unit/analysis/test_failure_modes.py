"""Failure modes and fault trees: minimal sets, names, likelihoods, hostile text."""

import csv
import io
import re
import time
from dataclasses import replace

import pytest
from lxml import etree
from openpyxl import load_workbook
from python_calamine import CalamineWorkbook

from mrsfi_runtime.analysis.documents import (
    FMEA,
    HEADS,
    as_open_psa,
    as_pfta,
    fmea,
)
from mrsfi_runtime.analysis.tables import plain
from mrsfi_runtime.causes.consequences import cut_sets
from mrsfi_runtime.causes.mildest import goal_weaknesses
from mrsfi_runtime.errors import printable
from mrsfi_runtime.model.faults import FaultPool
from mrsfi_runtime.model.mission import Requirement
from tests.integration.analysis.test_page import HOSTILE
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

SPECIAL = ["\\input{/etc/passwd}", "100 % & $x_1^2$ #{~}", "\\end{document}", "a\nb|c"]


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


ALL = [*HOSTILE, *SPECIAL, "@SUM(A1)", "-1", "\t=1", "_x0041_ \x00\x1f\ud800", "日 😀", "#N/A"]
NUMBERS = ("S", "O", "D", "RPN", "likelihood")
EMPTY = dict.fromkeys(HEADS, "") | dict.fromkeys(NUMBERS) | {"weakness": 7, "most ticks": 3}


def cells(text):
    """Return an FMEA whose texts are all this one, as CSV and as a workbook."""
    texts = dict.fromkeys((name for name, cell in EMPTY.items() if cell == ""), text)
    modes = [EMPTY | texts | {"S": 9, "likelihood": 0.1 * 0.2}, EMPTY]
    table = fmea(text, modes)
    read = csv.reader(io.StringIO(FMEA[".csv"](table).decode(), newline=""))
    book = CalamineWorkbook.from_filelike(io.BytesIO(FMEA[".xlsx"](table)))
    return [*read], book.get_sheet_by_index(0).to_python()


@pytest.mark.parametrize("text", ALL)
def test_every_text_is_a_string_in_spreadsheets_and_figures_are_equal_in_both(text):
    in_csv, in_book = cells(text)

    assert in_csv[0] == in_book[0] == [*HEADS]
    shown = printable(text)
    assert {*in_book[1][1:9]} == {shown}
    assert {*in_csv[1][1:9]} == {f"'{shown}" if shown[0] in "=+-@" else shown}
    assert [in_book[1][k] for k in (0, 9, 22, 24)] == [7, 9, 0.02, 3]
    assert [float(in_csv[1][k]) for k in (0, 9, 22, 24)] == [7, 9, 0.02, 3]
    assert [k for k, cell in enumerate(in_csv[2]) if cell] == [0, 24]
    assert [k for k, cell in enumerate(in_book[2]) if cell != ""] == [0, 24]


def test_no_text_is_a_formula_in_a_workbook_also_after_it_is_edited():
    book = load_workbook(io.BytesIO(FMEA[".xlsx"](fmea("m", [EMPTY | {"item": "=1+1"}]))))

    cell = book.active["B2"]

    assert (cell.value, cell.data_type, cell.quotePrefix) == ("=1+1", "s", True)


def test_equal_tables_have_equal_bytes_whenever_they_are_written(monkeypatch):
    first = FMEA[".xlsx"](fmea("m", [EMPTY]))
    monkeypatch.setattr(time, "time", lambda: 2e9)

    assert FMEA[".xlsx"](fmea("m", [EMPTY])) == first


@pytest.mark.parametrize("text", ALL)
def test_no_text_becomes_markup_or_a_command(text):
    table = fmea(text, [EMPTY | {"item": text, "status": text}])

    title, _, *lines = FMEA[".md"](table).decode().splitlines()
    document = FMEA[".tex"](table).decode()

    assert title == f"# Failure modes of mission {plain(text)}"
    assert [len(re.findall(r"(?<!\\)\|", line)) for line in lines] == [len(HEADS) + 1] * 3
    assert "<" not in title + lines[-1]
    assert document.count("\\item[") == len(HEADS) - 1
    assert {*re.findall(r"\\(input|end\{document)", document)} == {"end{document"}


def test_a_requirement_has_a_tree_of_its_goals_which_keep_theirs():
    mission = paper_mission()
    of = {"g1": ("R1",), "g2": ("R1", "g3"), "g3": ("R1",)}
    goals = tuple(replace(each, requirements=of.get(each.id, ())) for each in mission.goals)
    wanted = [Requirement("R1", "never\n<both>"), Requirement("g3", "="), Requirement("R4", "x")]
    mission = replace(mission, goals=goals, requirements=tuple(wanted))

    root = etree.fromstring(as_open_psa(mission, pool_of(), FOUND))

    trees = {
        each.get("name"): each.find("define-gate") for each in root.findall("define-fault-tree")
    }
    assert [*trees] == ["g2", "g3", "R1", "g3-2"]
    assert _inputs(trees["R1"].find("or")) == [("gate", "g2"), ("gate", "g3")]
    assert _inputs(trees["g3-2"])[1:] == [("gate", "g2")]
    assert trees["R1"].findtext("label") == "Violated: R1: never <both>"
