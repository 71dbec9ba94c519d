"""What is written for others: weaknesses, hostile text, discs."""

import re
from dataclasses import replace
from html.parser import HTMLParser

import pytest

from mrsfi_runtime.analysis.documents import in_latex, to_latex
from mrsfi_runtime.analysis.story import working_window
from mrsfi_runtime.analysis.tables import Table, to_html
from mrsfi_runtime.analysis.weaknesses import harmless
from mrsfi_runtime.api import Patrol, Stay, Visit
from mrsfi_runtime.causes.harvest import Harvest
from mrsfi_runtime.causes.weakness import Known
from mrsfi_runtime.model.faults import TimedFault
from mrsfi_runtime.model.mission import Coordinates, Goal
from tests.integration.analysis.test_page import HOSTILE
from tests.support.campaigns import area, outcome
from tests.support.search import paper_mission, paper_space, pool_of
from tests.support.weaknesses import weakness

POOL = pool_of("f2", "f3", "f7", "f9")
SPECIAL = ["\\input{/etc/passwd}", "100 % & $x_1^2$ #{~}", "\\end{document}", "a\nb"]


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

    places = [(each.label, each.area) for each in waters.goal_discs]
    assert [(label, at.center.x, at.center.y, at.radius) for label, at in places] == [
        ("g4", -250, 250, 150),
        ("g5", 250, 250, 150),
        ("g6", 250, -250, 150),
    ]


def test_areas_and_points_of_other_tasks_are_places_too():
    goals = (
        Goal("g1", "Patrol", ("r1",), Patrol(area("a1", 1, 2, 3), 10)),
        Goal("g2", "Stay", ("r1",), Stay(area("a2", 4, 5, 6))),
        Goal("g3", "Visit", ("r1",), Visit(Coordinates(7, 8), 9, 10)),
        Goal(
            "g4",
            "Round",
            ("r1",),
            Patrol(period=9, route=(area("a4", 1, 2, 3), area("a5", 4, 5, 6))),
        ),
    )

    found = replace(paper_mission(), goals=goals).goal_discs

    places = [(each.label, each.area) for each in found]
    assert [(label, at.center.x, at.center.y, at.radius) for label, at in places] == [
        ("g1", 1, 2, 3),
        ("g2", 4, 5, 6),
        ("g3", 7, 8, 9),
        ("g4 1", 1, 2, 3),
        ("g4 2", 4, 5, 6),
    ]
    assert [*goals[3].terms.path] == [Coordinates(1, 2), Coordinates(4, 5), Coordinates(1, 2)]


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
