"""The FMEA of a mission with requirements and severities, by a table of the team's."""

import csv
import re
from datetime import date
from xml.sax.saxutils import quoteattr

import pytest
from python_calamine import CalamineWorkbook

from mrsfi_runtime.analysis.documents import in_latex
from mrsfi_runtime.analysis.tables import plain
from tests.support.cli import ROOT, edit, mrsfi, mrsfi_json, workspace
from tests.support.report_page import data_of

MISSION = "undersea"
COVER = ("--algorithm", "cover", "--evaluations", "150", "--no-explain")
REFERENCE = ("--engine", "reference", "--workers", "1")
PAGE = (ROOT / "docs" / "find-weaknesses.md").read_text(encoding="utf-8")
(RATINGS,) = re.findall(r"```toml\n(\[fmea\]\n.*?)```", PAGE, re.DOTALL)

HOSTILE = "=1+1 </script><b>| \\input{x} $y_1$"
"""The text of requirement R2."""


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    """Folder of a project with a team's table and a campaign."""
    folder = workspace(tmp_path_factory.mktemp("place"), MISSION)
    (folder / "mrsfi.toml").write_text(RATINGS, encoding="utf-8")
    model, text = folder / "models" / MISSION / "mission.xmi", quoteattr(HOSTILE)
    edit(model, '"In 10 s, the sensors use at most 120 energy units."', text)
    mrsfi("generate", MISSION, cwd=folder)
    mrsfi("evolve", MISSION, *COVER, *REFERENCE, "--out", "runs/cover", cwd=folder)
    return folder


def written(place, path, *goal):
    mrsfi("weaknesses", "runs/cover", *goal, "--fmea", path, *REFERENCE, cwd=place)
    return path.read_bytes()


def test_a_workbook_has_the_cells_of_the_csv_and_the_same_bytes_again(place, tmp_path):
    goal = ("--goal", "r1_depths")
    table, book = (written(place, tmp_path / f"a.{name}", *goal) for name in ("csv", "xlsx"))

    assert written(place, tmp_path / "b.xlsx", *goal) == book
    head, *rows = csv.reader(table.decode().splitlines())
    names, *lines = (
        CalamineWorkbook.from_path(tmp_path / "a.xlsx").get_sheet_by_index(0).to_python()
    )
    assert names == head
    figures = {"weakness", "S", "O", "D", "RPN", "likelihood", "most ticks"}
    for row, line in zip(rows, lines, strict=True):
        for name, cell, in_book in zip(head, row, line, strict=True):
            is_figure = name in figures and cell
            assert in_book == (float(cell) if is_figure else cell.removeprefix("'"))


def test_rows_have_the_numbers_of_model_and_team_the_most_severe_first(place, tmp_path):
    written(place, tmp_path / "a.csv")
    found = {each["number"]: each for each in mrsfi_json("weaknesses", "runs/cover", cwd=place)}

    rows = [*csv.DictReader((tmp_path / "a.csv").read_text("utf-8").splitlines())]

    severities = [int(row["S"] or 0) for row in rows]
    assert severities == sorted(severities, reverse=True) != [0] * len(rows)
    for row in rows:
        one, chance = found[int(row["weakness"])], row["likelihood"]
        worst = (one["detection"] or {}).get("worst")
        assert row["D"] == {"never": "10", "late": "6", "in time": "2", None: ""}[worst]
        least = {1: 0, 4: 0.0001, 7: 0.01, 10: 0.1}
        o = max((n for n, each in least.items() if chance and each <= float(chance)), default="")
        assert row["O"] == str(o)
        assert bool(row["S"]) == (one["measure"] != "believed")
        known = [int(row[name]) for name in "SOD" if row[name]]
        assert row["RPN"] == (str(known[0] * known[1] * known[2]) if len(known) == 3 else "")
    assert any(row["RPN"] for row in rows)
    assert {row["requirement"][:2] for row in rows} == {"R1", "R2", ""}


def test_rows_say_what_the_team_decided_and_kept(place, tmp_path):
    given = ("--by", "=1+1 | \\input", "--because")
    mrsfi("decide", "runs/cover", "1", "mitigate", *given, "@SUM(1)\nof it", cwd=place)
    mrsfi("decide", "runs/cover", "2", "accept", *given, "rare", "--until", "2999-01-01", cwd=place)
    mrsfi("keep", "runs/cover", "--weakness", "2", "--name", "second", cwd=place)
    mrsfi("keep", "runs/cover", "--weakness", "3", "--name", "third", cwd=place)

    written(place, tmp_path / "a.csv")

    rows = csv.DictReader((tmp_path / "a.csv").read_text("utf-8").splitlines())
    columns = ("recommended action", "owner", "status")
    of = {row["weakness"]: [row[name] for name in columns] for row in rows}
    today, by = date.today(), "=1+1 | \\input"
    one = f"to be mitigated, decided by {by} on {today}: @SUM(1) of it"
    assert of["1"] == ["'@SUM(1) of it", f"'{by}", one]
    two = f"accepted by {by} on {today} until 2999-01-01: rare; kept as a test (second)"
    assert of["2"] == ["", f"'{by}", two]
    assert of["3"] == ["", "", "kept as a test (third)"]
    assert all(cells == [""] * 3 for number, cells in of.items() if number not in {*"123"})


def test_a_hostile_text_of_a_requirement_is_text_wherever_it_is_printed(place):
    mrsfi("report", "runs/cover", "--format", "latex", cwd=place)

    run = place / "runs" / "cover"
    printed = " ".join(mrsfi("weaknesses", "runs/cover", cwd=place).stdout.split())
    words = f"R2 ({HOSTILE}), severity 9 of 10, SIL 2"
    assert words in printed
    assert plain(words) in (run / "report.md").read_text(encoding="utf-8")
    assert in_latex(words) in (run / "report.tex").read_text(encoding="utf-8")
    goals = data_of(run / "report.html")["first"]["goals"]
    assert f"requirement {words}" in [each["stakes"] for each in goals]


def test_a_requirement_has_a_fault_tree_over_its_goals(place, tmp_path):
    path = tmp_path / "trees.txt"

    mrsfi("weaknesses", "runs/cover", "--fault-tree", path, cwd=place)

    gates = path.read_text("utf-8").split("\n\n")
    (required,) = (each for each in gates if each.startswith("Gate: R1\n"))
    assert (
        "- label: Violated: R1: In 10 s, the vehicle takes at least 20 measurements.\n" in required
    )
    assert required.endswith("- inputs: r1_temperatures, r1_pressures, r1_depths")
