from types import SimpleNamespace
from typing import Any

import pytest
from rich.table import Table

from mrsfi_runtime.cli.console import print_table
from mrsfi_runtime.cli.tables import critical_tables, plain_table
from tests.support.campaigns import evaluation
from tests.support.search import pool_of

FAULTS = tuple(fault.id for fault in pool_of())


def _tables(n_goals: int) -> tuple[Table, Table]:
    measure: Any = SimpleNamespace(
        goals=tuple(f"g{number}" for number in range(1, n_goals + 1)), is_shown_by_outcomes=True
    )
    believed = tuple(900 + number if number % 3 else 0 for number in range(n_goals))
    return critical_tables(measure, pool_of(), [evaluation(123, believed, fitness=809.8)])


def _printed(capsys: pytest.CaptureFixture[str], *tables: Table) -> list[str]:
    print_table("The most critical", *tables)
    return capsys.readouterr().out.splitlines()[1:]


@pytest.fixture(autouse=True)
def _in_a_pipe(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("COLUMNS", raising=False)


def test_six_goals_have_a_column_each_in_a_pipe(capsys):
    head, _, believed, *_ = _printed(capsys, *_tables(6))

    assert head.split()[:5] == ["#", "evaluation", "fitness", "violations", "g1"]
    assert believed.split()[:6] == ["1", "123", "809.80", "believed", "0", "901"]
    assert len(head) <= 100


@pytest.mark.parametrize("n_goals", [11, 40])
def test_what_identifies_a_specification_never_gives_way_to_goals(capsys, n_goals):
    lines = _printed(capsys, *_tables(n_goals))

    assert lines[0].split() == ["#", "evaluation", "fitness", "violations", "faults"]
    text = " ".join(lines)
    assert text.split("─ ")[-1].split()[:4] == ["1", "123", "809.80", "believed"]
    assert "…" not in text
    assert "g2:901" in text.split()
    assert max(map(len, lines)) <= 100


def test_columns_says_how_many_there_are(capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", "160")

    head, *_ = _printed(capsys, *_tables(11))

    assert head.split()[-2:] == ["g11", "faults"]
    assert 100 < len(head) <= 160


@pytest.mark.parametrize("columns", ["1", "30", "60", "80"])
def test_no_number_or_word_is_cut_however_narrow_it_is(capsys, monkeypatch, columns):
    monkeypatch.setenv("COLUMNS", columns)
    table = plain_table(("goal",), ("believed", "true"))
    table.add_row("g1_area_of_the_harbour", "1234567", "7654321")

    words = " ".join(_printed(capsys, *_tables(11)) + _printed(capsys, table)).split()

    assert {"evaluation", "fitness", "809.80", "123", "g2:901", "g11:910"} <= {*words}
    assert {"g1_area_of_the_harbour", "1234567", "7654321", "believed"} <= {*words}
