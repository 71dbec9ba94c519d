from dataclasses import replace
from typing import Any

import pytest

from mrsfi_runtime.analysis.tables import (
    Table,
    critical_table,
    fault_table,
    goal_table,
    goals_as_json,
)
from mrsfi_runtime.cli.terminal import print_table
from mrsfi_runtime.model.faults import TimedFault
from mrsfi_runtime.record.observers import named_faults
from mrsfi_runtime.record.store import Measure
from tests.support.campaigns import evaluation, outcome
from tests.support.search import paper_mission, pool_of

FAULTS = tuple(fault.id for fault in pool_of())


def _table(n_goals: int, **counts: Any) -> Table:
    goals = tuple(f"g{number}" for number in range(1, n_goals + 1))
    believed = tuple(900 + number if number % 3 else 0 for number in range(n_goals))
    found = evaluation(123, believed, fitness=809.8)
    told = replace(found, outcome=replace(found.outcome, **counts))
    return critical_table(Measure("believed", 1, goals, goals, 1000), pool_of(), [told], 1)


def _printed(capsys: pytest.CaptureFixture[str], table: Table) -> list[str]:
    print_table(table)
    return capsys.readouterr().out.splitlines()[1:]


@pytest.fixture(autouse=True)
def _in_a_pipe(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("COLUMNS", raising=False)


def test_six_goals_have_a_column_each_in_a_pipe(capsys):
    head, _, believed, *_ = _printed(capsys, _table(6))

    assert head.split()[:5] == ["#", "evaluation", "fitness", "violations", "g1"]
    assert believed.split()[:6] == ["1", "123", "809.80", "believed", "0", "901"]
    assert len(head) <= 100


@pytest.mark.parametrize(
    ("missed", "expected"),
    [((0, 1000, 288), ["–", "0", "712"]), ((0, 0, 0), ["–"] * 3)],
)
def test_a_line_says_from_which_tick_on_a_goal_failed(capsys, missed, expected):
    *_, line = _printed(capsys, _table(3, missed=missed))[:5]

    assert line.split() == ["failed", "from", *expected]


def test_what_happened_to_the_papers_goals_fits_into_80_columns(capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    flown = replace(outcome((0, 901, 934, 856, 901, 986)), missed=(0, 0, 0, 288, 1000, 1))

    above, head, rule, *rows = _printed(capsys, goal_table("", paper_mission(), flown))

    assert (above.split(), head.split()[-3:]) == (["failed"], ["masked", "from", "samples"])
    assert max(map(len, (above, head, rule, *rows))) <= 80
    assert [row.split()[6] for row in rows[:6]] == ["–", "–", "–", "712", "0", "999"]


def test_a_script_gets_the_ticks_that_a_goal_was_missed_and_since_when():
    flown = replace(outcome((0, 901, 934, 856, 901, 986)), missed=(0, 0, 0, 288, 1000, 1))

    flown = replace(flown, margins=(None, None, None, (2.5, 412), None, None))

    *_, third, fourth, fifth, _ = goals_as_json(paper_mission(), flown)

    assert fourth == {
        "id": "g4",
        "task": "GatherSamples",
        "believed": 856,
        "true": 428,
        "phantom": 428,
        "masked": 0,
        "missed": 288,
        "missed_since": 712,
        "samples": 0,
        "margin": 2.5,
        "nearest": 412,
    }
    assert third["margin"] is third["nearest"] is None
    assert (third["missed"], third["missed_since"]) == (0, None)
    assert (fifth["missed"], fifth["missed_since"]) == (1000, 0)


@pytest.mark.parametrize("n_goals", [11, 40])
def test_what_identifies_a_specification_never_gives_way_to_goals(capsys, n_goals):
    lines = _printed(capsys, _table(n_goals))

    assert lines[0].split() == ["#", "evaluation", "fitness", "violations", "faults"]
    text = " ".join(lines)
    assert text.split("─ ")[-1].split()[:4] == ["1", "123", "809.80", "believed"]
    assert "…" not in text
    assert "g2:901" in text.split()
    assert max(map(len, lines)) <= 100


@pytest.mark.parametrize("columns", ["1", "30", "60", "80"])
def test_no_number_or_word_is_cut_however_narrow_it_is(capsys, monkeypatch, columns):
    monkeypatch.setenv("COLUMNS", columns)
    columns = ("goal", "believed", "true")
    table = Table("", columns, [("g1_area_of_the_harbour", 1234567, 7654321)], ("goal",))

    words = " ".join(_printed(capsys, _table(11)) + _printed(capsys, table)).split()

    assert {"evaluation", "fitness", "809.80", "123", "g2:901", "g11:910"} <= {*words}
    assert {"g1_area_of_the_harbour", "1234567", "7654321", "believed"} <= {*words}


def test_numbers_of_two_words_go_on_below_where_they_do_not_fit_and_no_heading_is_cut(
    capsys, monkeypatch
):
    monkeypatch.setenv("COLUMNS", "40")
    columns = ("fault", *(f"g{k}\nbelieved" for k in range(4)))
    table = Table("", columns, [("f1", 0.5, "-147.4 ±49.2", "1.0 ±0.0", None)], ("fault",))

    head, below, _, first, second, *_ = _printed(capsys, table)

    assert (head.split(), below.split()) == (["g0", "g1", "g2", "g3"], ["fault", *["believed"] * 4])
    assert first.split() == ["f1", "0.5", "-147.4", "1.0", "±0.0", "–"]
    assert second.split() == ["±49.2"]


@pytest.mark.parametrize(
    ("width", "expected"),
    [
        (40, "name g1 g2 of r 10 – robot1 0 7"),
        (20, "name g1 g2 r 10 – 0 7 Left out for lack of width: of"),
        (12, "name goals r g1:10 g1:0 g2:7 Left out for lack of width: of"),
    ],
)
def test_where_a_table_does_not_fit_spare_columns_go_then_those_that_fold(
    capsys, monkeypatch, width, expected
):
    monkeypatch.setenv("COLUMNS", str(width))
    columns, rows = ("name", "g1", "g2", "of"), [("r", "10\n0", "–\n7", "robot1")]
    folded = ("goals", columns[1:3])
    table = Table("", columns, rows, ("name", "of"), spare=("of",), folded=folded)

    words = " ".join(_printed(capsys, table)).replace("─", "").split()

    assert " ".join(words) == expected


@pytest.mark.parametrize(("columns", "n_lines"), [("1", None), ("100", None), ("200", 30)])
def test_every_fault_has_its_target_and_its_values_however_narrow_it_is(
    capsys, monkeypatch, columns, n_lines
):
    monkeypatch.setenv("COLUMNS", columns)
    specification = [TimedFault(fault.id, 3, 9, fault.values) for fault in pool_of()]
    faults = named_faults(paper_mission(), pool_of(), specification)

    lines = _printed(capsys, fault_table("", faults, outcome((0,) * 6, len(faults))))

    words = " ".join(lines).split()
    assert "…" not in words
    for fault in faults:
        assert {*fault.target.split(), *fault.values.split(), fault.fault.type} <= {*words}
    rows = [line for line in lines if line.startswith("f") and line[1].isdigit()]
    assert len(rows) == len(faults)
    if n_lines is not None:
        assert [*lines[2 : 2 + n_lines]] == rows
    assert columns != "100" or max(map(len, lines)) <= 100
