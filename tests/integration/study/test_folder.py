"""The folder of a comparison, with its figures."""

import csv
import json
from pathlib import Path

import pytest

from mrsfi_runtime.study.comparison import as_json
from mrsfi_runtime.study.folder import ComparisonFolder
from tests.support.comparisons import compared, new_folder


@pytest.fixture
def folder(tmp_path: Path) -> ComparisonFolder:
    return new_folder(tmp_path)


def table(path: Path) -> list[dict[str, str]]:
    with path.open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def test_tables_have_every_run_quartile_and_test(folder):
    comparison = compared()

    folder.write(comparison, as_json(comparison))

    runs = table(folder.path / "runs.csv")
    assert [(row["algorithm"], row["seed"]) for row in runs[:4]] == [
        ("paper", "1"),
        ("paper", "2"),
        ("paper", "3"),
        ("my.own:search", "11"),
    ]
    assert float(runs[0]["fitness"]) == comparison.runs[0].best_fitness
    assert runs[0]["digest"] == comparison.runs[0].digest
    assert {row["n_runs"] for row in table(folder.path / "quartiles.csv")} == {"3"}
    tests = table(folder.path / "tests.csv")
    assert len(tests) == len(comparison.tests)
    assert float(tests[0]["p_value"]) == comparison.tests[0].ranks.p_value
    assert json.loads(folder.summary.read_text()) == json.loads(json.dumps(as_json(comparison)))
