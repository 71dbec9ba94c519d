"""Names of forms, and the sets of faults of which a table of failure modes has a row each."""

import pytest

from mrsfi_runtime.analysis.fmea import FailureMode, Names, as_csv, as_markdown, by_set, forms
from tests.support.search import paper_mission
from tests.support.weaknesses import weakness


def test_a_set_is_one_way_to_break_a_goal_with_the_gravest_measure_last():
    found = [
        weakness("g3", "missed", "f9"),
        weakness("g2", "true", "f9", "f2"),
        weakness("g2", "missed", "f11"),
        weakness("g2", "believed", "f11"),
    ]

    told = by_set(paper_mission(), found)

    assert [[each.column for each in alike.values()] for alike in told] == [
        [("g2", "believed"), ("g2", "missed")],
        [("g2", "true")],
        [("g3", "missed")],
    ]
    assert [alike["missed"].faults for alike in told if "missed" in alike] == [("f11",), ("f9",)]


def test_a_form_is_named_once_for_a_goal_by_the_measure_only_where_a_graver_one_has_another():
    found = [
        weakness("g2", "believed", "f9", start=1),
        weakness("g2", "true", "f9", start=5),
        weakness("g2", "missed", "f9", start=5),
        weakness("g2", "true", "f9", "f11"),
        weakness("g3", "true", "f9", start=5),
    ]

    named = {
        name: (goal, form[0].start) for (goal, form), name in forms(paper_mission(), found).items()
    }

    assert named == {
        "g2-f9": ("g2", 5),
        "g2-f9-believed": ("g2", 1),
        "g2-f11-f9": ("g2", 10),
        "g3-f9": ("g3", 5),
    }


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (("g2", "f9"), "g2-f9"),
        (("G2", "F9"), "G2-F9-2"),
        (("a b", "x.1", "y-2"), "a_b-x_1-y_2"),
        (("../é", "con"), "____-con"),
        (("x" * 300,), "x" * 100),
    ],
)
def test_names_are_those_of_files_on_any_system(words, told):
    names = Names()
    names.of("g2", "f9") if words == ("G2", "F9") else None

    assert names.of(*words) == told


def test_no_cell_is_a_formula_in_a_spreadsheet_or_markup_on_a_page():
    texts = ("f9", "-a", "b|c", "<d", "=1+1 (g1)", "true", "no", "g1-f9", "violated")
    modes = [FailureMode(*texts, 3, chance) for chance in (0.1 * 0.2, None)]

    table = as_csv(paper_mission(), modes).decode().splitlines()
    page = as_markdown(paper_mission(), modes).decode().splitlines()

    assert table[0] == ",".join(FailureMode._fields)
    assert table[2] == "f9,'-a,b|c,<d,'=1+1 (g1),true,no,g1-f9,violated,3,"
    assert page[0] == "# Failure modes of mission uuv_sampling"
    told = "| f9 | -a | b\\|c | &lt;d | =1+1 (g1) | true | no | g1-f9 | violated | 3 | "
    assert page[-2:] == [f"{told}0.02 |", f"{told}– |"]
