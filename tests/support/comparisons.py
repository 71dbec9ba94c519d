"""Results of runs, a comparison of them, and a folder for both."""

from pathlib import Path
from typing import Any

from mrsfi_runtime.record.settings import CampaignSettings
from mrsfi_runtime.study.comparison import Comparison, RunResult, compare, measure_run
from mrsfi_runtime.study.folder import ComparisonFolder
from tests.support.campaigns import generations_of_evaluations, store_of
from tests.support.search import paper_mission


def result(algorithm: str, seed: int) -> RunResult:
    evaluations = [one for members in generations_of_evaluations(4, 10, seed) for one in members]
    settings = CampaignSettings(algorithm=algorithm, seed=seed, goals=("g1", "g3"))
    with store_of(evaluations, settings) as store:
        return measure_run(store, paper_mission(), 0.5)


def run_result(algorithm: str, seed: int, **found: Any) -> RunResult:
    """Return the result of a run, with some of what it found."""
    values = {
        "n_evaluations": 50,
        "n_failures": 0,
        "at_once": (1, None, None),
        "together": (1, 2, None),
        "front_size": 4,
        "seconds": 2.0 * seed,
        "digest": f"{algorithm}{seed}",
    }
    return RunResult(algorithm=algorithm, seed=seed, **(values | found))


def new_folder(place: Path) -> ComparisonFolder:
    made = ComparisonFolder(place / "compared")
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
