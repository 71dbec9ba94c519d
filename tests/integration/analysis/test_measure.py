"""A report that says which counts a campaign used."""

import json
from pathlib import Path

import pytest

from mrsfi_runtime.record.engine_settings import Manifest
from mrsfi_runtime.record.settings import CampaignSettings
from mrsfi_runtime.record.store import CampaignStore, Evaluation, Generation, Measure
from tests.support.campaigns import statistics
from tests.support.drawing import table, write_report
from tests.support.measures import FLOWN_TWICE, HIDING, MASKED, MEANS
from tests.support.search import paper_mission
from tests.support.world import paper_code
from tests.tiers import slow

CODE = paper_code()


def report_of(folder: Path, settings: CampaignSettings, found: list[Evaluation]) -> str:
    with CampaignStore.create(folder, settings, Manifest()) as store:
        population = tuple(each.index for each in found)
        store.append(found, (), [Generation(0, statistics(found), population, "[]")])
    write_report(folder, CODE.mission, CODE.pool, lambda *_: None, ratio="g1:g3=1:1")
    return (folder / "report.md").read_text()


@slow
@pytest.mark.parametrize(
    ("settings", "found", "rows"),
    [
        (MASKED, HIDING, [["1", "2", "5"], ["0", "3", "1"]]),
        (MEANS, FLOWN_TWICE, [["0", "450.0", "451.5"], ["1", "500.5", "12.0"]]),
    ],
)
def test_a_report_uses_the_measure_and_says_which_it_is(settings, found, rows, tmp_path):
    measure = Measure.of(settings, paper_mission())
    best = max(found, key=lambda each: each.fitness[0])

    report = report_of(tmp_path / "run", settings, found)

    summary = json.loads((tmp_path / "run" / "summary.json").read_text())
    figure = (tmp_path / "run" / "figures" / "figure_11_front.svg").read_text()
    assert table(tmp_path / "run", "figure_11_front")[1:] == rows
    assert table(tmp_path / "run", "figure_10_front_by_generation")[1:] == [
        ["0", *row] for row in rows
    ]
    assert f"trade-offs between g1, g3 ({measure})\n" in report
    assert f"For each goal, {measure}; then" in report
    assert summary["measure"] == {"violations": measure.kind, "mission_seeds": measure.n_seeds}
    assert summary["top"][0]["measured"] == measure.by_goal(best)
    assert f"g1: {measure} (ticks)" in figure
