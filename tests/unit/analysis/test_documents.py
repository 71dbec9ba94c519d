"""What is written for others: fault trees, failure modes, weaknesses, hostile text, discs."""

import re
from dataclasses import replace
from html.parser import HTMLParser

import pytest
from lxml import etree

from mrsfi_runtime.analysis.documents import as_open_psa, as_pfta, in_latex, to_latex
from mrsfi_runtime.analysis.story import working_window
from mrsfi_runtime.analysis.tables import Table, to_html
from mrsfi_runtime.analysis.weaknesses import FailureMode, harmless, modes_as_csv, modes_as_markdown
from mrsfi_runtime.api import Patrol, Stay, Visit
from mrsfi_runtime.causes.harvest import Harvest
from mrsfi_runtime.causes.mildest import goal_weaknesses
from mrsfi_runtime.causes.risk import cut_sets
from mrsfi_runtime.causes.weakness import Known
from mrsfi_runtime.model.faults import FaultPool, TimedFault
from mrsfi_runtime.model.mission import Coordinates, Goal
from tests.integration.analysis.test_page import HOSTILE
from tests.support.campaigns import area, outcome
from tests.support.search import PAPER_FAULTS, paper_mission, paper_space, pool_of
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
POOL = pool_of("f2", "f3", "f7", "f9")
SPECIAL = ["\\input{/etc/passwd}", "100 % & $x_1^2$ #{~}", "\\end{document}", "a\nb"]


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


@pytest.mark.parametrize(
    "found",
    [
        (),
        (weakness("g1", "believed", "f9"), weakness("g2", "true", "f3", "f9")),
        (weakness("g1", "missed", "f9"), weakness("g2", "true", "f2", "f3")),
        (weakness("g1", "true", "f2", "f3"), weakness("g2", "true", "f7", "f9")),
    ],
)
def test_faults_that_are_in_no_way_to_break_a_goal_are_named_in_the_order_of_the_pool(
    found, approved
):
    first, second = TimedFault("f2", 0, 9), TimedFault("f7", 0, 9, (1.0,))
    flown = [(first,), (first._replace(finish=5),), (first, second), (second,)]
    outcomes = {each: outcome([0] * 6, len(each)) for each in flown[:3]}
    outcomes[flown[3]] = replace(outcome([0] * 6), changed=(0,))

    approved(harmless(POOL, Harvest(Known(paper_space()), found, 0, outcomes, None)))


class Tags(HTMLParser):
    """Names of the elements of a text, and what it shows."""

    def __init__(self, text):
        super().__init__()
        self.tags = set()
        self.text = ""
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        self.tags.add(tag)
        assert not attrs

    def handle_data(self, data):
        self.text += data


@pytest.mark.parametrize("text", HOSTILE + SPECIAL)
def test_no_cell_or_title_becomes_markup_in_html(text):
    found = Tags(to_html(Table(text, (text,), [(text,)], (text,))))

    assert found.tags <= {"table", "caption", "thead", "tbody", "tr", "th", "td"}
    assert text.split()[0][:10] in found.text or not text.isprintable()


@pytest.mark.parametrize("text", HOSTILE + SPECIAL)
def test_no_cell_or_title_becomes_a_command_in_latex(text):
    known = {"begin", "centering", "caption", "resizebox", "ifdim", "width", "textwidth", "else"}
    known |= {"fi", "toprule", "midrule", "bottomrule", "end"}

    written = to_latex(Table(text, (text,), [(text,)], (text,)))

    commands = {*re.findall(r"\\([A-Za-z]+)", written)}
    assert commands <= known | {
        "textbackslash",
        "textasciitilde",
        "textasciicircum",
        "textless",
        "textgreater",
    }
    assert written.count("\\begin{") == written.count("\\end{") == 2
    assert not re.search(r"(?<!\\)[#$^~]", written.replace("\\textasciicircum", ""))


def test_letters_that_mean_something_to_latex_stand_as_they_are():
    assert in_latex("a_b & 5 % of {x}") == r"a\_b \& 5 \% of \{x\}"
    assert in_latex("* [日]") == "{*} {[}{[}U+65E5]]"
    assert in_latex("\\n ~ ^") == r"\textbackslash{}n \textasciitilde{} \textasciicircum{}"


def test_only_areas_that_a_task_reads_are_places():
    waters = paper_mission()
    unread = replace(waters.goals[0], area=area("a9", 600, -200, 4))
    waters = replace(waters, goals=(unread, *waters.goals[1:]))

    assert [(p.goal.id, p.x, p.y, p.radius) for p in waters.goal_discs] == [
        ("g4", -250, 250, 150),
        ("g5", 250, 250, 150),
        ("g6", 250, -250, 150),
    ]


def test_areas_and_points_of_other_tasks_are_places_too():
    goals = (
        Goal("g1", "Patrol", ("r1",), Patrol(area("a1", 1, 2, 3), 10)),
        Goal("g2", "Stay", ("r1",), Stay(area("a2", 4, 5, 6))),
        Goal("g3", "Visit", ("r1",), Visit(Coordinates(7, 8), 9, 10)),
    )

    places = replace(paper_mission(), goals=goals).goal_discs

    assert [(p.x, p.y, p.radius) for p in places] == [(1, 2, 3), (4, 5, 6), (7, 8, 9)]


def test_the_window_holds_every_start_obstacle_and_goal_area():
    x, y, half = working_window(paper_mission())

    assert x - half < -545 < 545 < x + half
    assert y - half < -530 < 550 < y + half
    assert half < 700


def test_a_mission_at_one_point_still_has_a_window():
    waters = replace(
        paper_mission(),
        obstacles=(),
        goals=paper_mission().goals[:1],
        robots=paper_mission().robots[:1],
    )

    assert working_window(waters) == (250, -250, 20.0)
