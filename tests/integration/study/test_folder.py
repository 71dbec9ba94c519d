"""The folder of a comparison, with its figures."""

import csv
import json
from pathlib import Path

import pytest

from mrsfi_runtime.record.settings import CampaignSettings
from mrsfi_runtime.study.comparison import Comparison, as_json, compare
from mrsfi_runtime.study.folder import ComparisonFolder
from mrsfi_runtime.study.run_results import RunResult, measure_run
from tests.support.campaigns import generations_of_evaluations, mission


def result(algorithm: str, seed: int) -> RunResult:
    evaluations = [one for members in generations_of_evaluations(4, 10, seed) for one in members]
    return measure_run(
        CampaignSettings(algorithm=algorithm, seed=seed, goals=("g1", "g3")),
        mission(),
        evaluations,
        n_failures=0,
        seconds=0.5,
        digest=f"{seed:064x}",
    )


@pytest.fixture
def folder(tmp_path: Path) -> ComparisonFolder:
    made = ComparisonFolder(tmp_path / "compared")
    made.runs.mkdir(parents=True)
    return made


def compared() -> Comparison:
    return compare(
        ("paper", "my.own:search"),
        [
            result(name, seed + shift)
            for shift, name in ((0, "paper"), (10, "my.own:search"))
            for seed in (1, 2, 3)
        ],
    )


def table(path: Path) -> list[dict[str, str]]:
    with path.open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def test_tables_have_every_run_quartile_and_test(folder: ComparisonFolder) -> None:
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
    assert runs[0]["digest"] == f"{1:064x}"
    assert {row["n_runs"] for row in table(folder.path / "quartiles.csv")} == {"3"}
    tests = table(folder.path / "tests.csv")
    assert len(tests) == len(comparison.tests)
    assert float(tests[0]["p_value"]) == comparison.tests[0].ranks.p_value
    assert json.loads(folder.summary.read_text()) == json.loads(json.dumps(as_json(comparison)))


def test_figures_are_drawn_and_nothing_else_is_left(folder: ComparisonFolder) -> None:
    comparison = compared()

    folder.write(comparison, as_json(comparison))
    folder.write(comparison, as_json(comparison))

    assert sorted(file.name for file in folder.figures.iterdir()) == [
        f"{name}.{suffix}" for name in ("course", "goals", "results") for suffix in ("png", "svg")
    ]
    assert sorted(file.name for file in folder.path.iterdir()) == [
        "comparison.json",
        "figures",
        "quartiles.csv",
        "runs",
        "runs.csv",
        "tests.csv",
    ]
