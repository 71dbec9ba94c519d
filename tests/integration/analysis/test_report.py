import json
import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import pytest

from mrsfi_runtime.analysis.documents import report_text
from mrsfi_runtime.analysis.page import campaign_page
from mrsfi_runtime.analysis.summary import (
    Summary,
    illustrate,
    summarise,
)
from mrsfi_runtime.analysis.tables import fault_table
from mrsfi_runtime.errors import RecordError
from mrsfi_runtime.model.faults import FaultPool, Specification, TimedFault
from mrsfi_runtime.record.engine_settings import Manifest
from mrsfi_runtime.record.observers import named_faults
from mrsfi_runtime.record.settings import CampaignSettings
from mrsfi_runtime.record.store import CampaignStore, Generation
from tests.support.campaigns import (
    evaluation,
    generations_of_evaluations,
    statistics,
    write_campaign,
)
from tests.support.drawing import table, write_report
from tests.support.world import paper_code
from tests.tiers import slow

CODE = paper_code()
SINGLE = ["figure_05_mission_map", "figure_06_mean_fitness", "figure_07_best_fitness"]
FOCUSED = ["figure_05_mission_map", "figure_08_mean_fitness", "figure_09_best_fitness"]
FRONTS = ["figure_10_front_by_generation", "figure_11_front"]
HARM = ["figure_harm"]
TYPES = ["figure_12_fault_types"]
FOCUS = CampaignSettings(fitness="focused", goals=("g1", "g3"))


def write(
    pool: FaultPool, timed: Specification, path: Path, name: str, names: Sequence[str] | None
) -> None:
    """Stand in for the writer of XMI, which lives in another room."""
    assert {each.fault for each in timed} <= pool.by_id.keys()
    path.write_text(json.dumps([name, timed]))


def stems(folder: Path, suffix: str) -> list[str]:
    return sorted(path.stem for path in folder.glob(f"*{suffix}"))


@pytest.mark.parametrize(
    ("settings", "expected"),
    [
        (CampaignSettings(), SINGLE + TYPES),
        (CampaignSettings(goals=("g1", "g3")), SINGLE + FRONTS + TYPES),
        (FOCUS, FOCUSED + FRONTS + TYPES),
        (CampaignSettings(fitness="focused", goals=("g1",)), FOCUSED + TYPES),
        (CampaignSettings(minimise="faults"), SINGLE + HARM + TYPES),
        (replace(FOCUS, minimise="fault_ticks"), FOCUSED + HARM + FRONTS + TYPES),
        (CampaignSettings(goals=("g1",), minimise="faults"), SINGLE + HARM + TYPES),
    ],
)
def test_a_campaign_gets_the_figures_of_its_case(settings, expected, tmp_path):
    folder = write_campaign(tmp_path / "run", settings=settings, n_generations=2, n_individuals=3)

    with CampaignStore.open(folder) as store:
        summary, columns = summarise(folder, store, CODE.mission, CODE.pool, ratio=None)
        drawn = [*illustrate(summary, columns, store)]

    assert [illustration.name for illustration in drawn] == expected


@slow
def test_each_figure_has_its_files_and_its_link(focused):
    expected = FOCUSED + FRONTS + TYPES

    assert stems(focused / "figures", ".png") == expected
    assert stems(focused / "figures", ".svg") == expected
    assert stems(focused / "tables", ".csv") == ["evaluations", *expected]
    report = (focused / "report.md").read_text()
    assert all(f"(figures/{name}.png)" in report for name in expected)


@pytest.fixture(scope="module")
def focused(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("runs") / "focused"
    write_campaign(folder, settings=FOCUS)
    write_report(folder, CODE.mission, CODE.pool, write, ratio="g3:g1=2:1")
    return folder


def evaluations_of(folder: Path) -> list:
    with CampaignStore.open(folder) as store:
        return list(store.evaluations())


def test_the_ten_most_critical_specifications_are_written(focused):
    ranked = sorted(evaluations_of(focused), key=lambda e: -e.fitness[0])[:10]

    files = sorted((focused / "critical").iterdir())

    assert [file.name for file in files] == [f"{i:02d}.xmi" for i in range(1, 11)]
    for file, best in zip(files, ranked, strict=True):
        name, rows = json.loads(file.read_text())
        assert name == f"evaluation_{best.index}"
        assert [tuple(row[:3]) for row in rows] == [timed[:3] for timed in best.specification]
        assert [tuple(row[3]) for row in rows] == [t.values for t in best.specification]


def test_the_summary_says_what_was_found(focused):
    evaluations = evaluations_of(focused)
    best = max(evaluations, key=lambda e: e.fitness[0])

    summary = json.loads((focused / "summary.json").read_text())

    assert list(summary) == [
        "schema",
        "campaign",
        "mission",
        "settings",
        "measure",
        "semantics",
        "unrepeated",
        "n_generations",
        "n_evaluations",
        "n_distinct",
        "n_failures",
        "digest",
        "best",
        "top",
        "weaknesses",
        "front",
        "harm",
        "pick",
        "trend",
        "patterns",
    ]
    assert (summary["n_generations"], summary["n_evaluations"]) == (12, 120)
    assert summary["settings"] == FOCUS.as_json()
    with CampaignStore.open(focused) as store:
        assert summary["digest"] == store.digest()
    assert summary["best"] == summary["top"][0]
    assert summary["best"]["evaluation"] == best.index
    assert list(summary["best"]["believed"].values()) == list(best.outcome.believed)
    assert list(summary["best"]["true"]) == ["g1", "g2", "g3", "g4", "g5", "g6"]
    assert list(summary["best"]["true"].values()) == list(best.outcome.true)
    assert list(summary["best"]["missed"].values()) == list(best.outcome.missed)
    assert list(summary["best"]["missed_since"].values()) == list(best.outcome.missed_since(1000))
    assert summary["best"]["fault_ticks"] == best.fault_ticks
    assert [row["fault"] for row in summary["best"]["specification"]] == [
        timed.fault for timed in best.specification
    ]
    assert summary["pick"].pop("ratio") == "g3:g1=2:1"
    assert summary["pick"] in summary["front"]["points"]
    assert len(summary["patterns"]) == 30


def test_the_tables_hold_the_numbers_of_the_figures(focused):
    evaluations = evaluations_of(focused)

    mean = table(focused, "figure_08_mean_fitness")
    best = table(focused, "figure_09_best_fitness")
    by_generation = table(focused, "figure_10_front_by_generation")
    all_evaluations = table(focused, "evaluations")
    places = table(focused, "figure_05_mission_map")

    first = statistics([e for e in evaluations if e.generation == 0])
    assert mean[0] == ["generation", "mean", "std"]
    assert [float(cell) for cell in mean[1]] == [0, first["mean"], first["std"]]
    assert [float(cell) for cell in best[1]] == [0, first["max"]]
    assert sorted({int(row[0]) for row in by_generation[1:]}) == [0, 2, 5, 8, 11]
    assert len(all_evaluations) == 121
    assert all_evaluations[0][5:8] == ["believed_g1", "believed_g2", "believed_g3"]
    assert [int(cell) for cell in all_evaluations[1][5:11]] == list(evaluations[0].outcome.believed)
    assert all_evaluations[0][-8:-6] == ["missed_g6", "missed_since_g1"]
    since = evaluations[0].outcome.missed_since(1000)
    assert all_evaluations[1][-7:-1] == ["" if tick is None else str(tick) for tick in since]
    assert ["robot", "r1", "LEN", "250.0", "-250.0", "1.0"] in places


def test_the_report_warns_that_popular_is_not_guilty_and_tests_no_trend(focused):
    report = (focused / "report.md").read_text()

    assert "A frequent fault type need not be harmful" in report
    assert "The specification nearest to g3:g1=2:1: evaluation " in report
    assert "critical/10.xmi" in report
    assert "failed from" in report
    assert " (least squares). This describes one run and is not a statistical test" in report
    assert not re.search(r"\bp [<=] ", report)


@pytest.mark.parametrize("ratio", ["g3:g1=2:1", "g3:g1=1:1"])
def test_report_and_page_say_which_ratio_was_wanted_and_which_there_is(focused, ratio):
    with CampaignStore.open(focused) as store:
        summary, _ = summarise(focused, store, CODE.mission, CODE.pool, ratio)
        page = campaign_page(summary, store)
    assert summary.pick is not None
    (first, second) = (summary.pick.point.violations[front] for front in (1, 0))

    said = page["search"]["said"]

    assert f"The specification nearest to {ratio}: evaluation " in said
    assert f", which is {first / second:.3g}:1" in said
    assert said.rpartition("The specification ")[2] in report_text(summary, {})


def test_report_and_summary_name_every_fault_of_the_most_critical(focused):
    ranked = sorted(evaluations_of(focused), key=lambda e: -e.fitness[0])[:10]

    top = json.loads((focused / "summary.json").read_text())["top"]
    sections = (focused / "report.md").read_text().split("\n### Specification ")[1:]

    assert len(top) == len(sections) == 10
    for rank, (best, told, section) in enumerate(zip(ranked, top, sections, strict=True), 1):
        faults = named_faults(CODE.mission, CODE.pool, best.specification)
        assert told["specification"] == [
            {"fault": fault.timed.fault, **fault.as_json()} for fault in faults
        ]
        assert section.startswith(f"{rank}, evaluation {best.index}\n")
        lines = [line for line in section.splitlines() if line.startswith("| f")]
        rows = [line.strip("| ").split(" | ") for line in lines[: 1 + len(faults)]]
        table = fault_table("", faults, best.outcome)
        assert rows == [[str(cell) for cell in row] for row in table.lines]


@slow
def test_a_campaign_that_minimises_reports_harm_against_it(tmp_path):
    settings = CampaignSettings(minimise="faults", goals=("g2",), violations="true")
    small, large = (
        tuple(TimedFault("f8", 20 * n, 20 * n + 9, (1.0,)) for n in range(size)) for size in (1, 3)
    )
    found = [
        evaluation(0, (0, 9, 0, 0, 0, 0), specification=large),
        evaluation(1, (8, 4, 0, 0, 0, 0), specification=small),
        evaluation(2, (8, 1, 0, 0, 0, 0), specification=large),
    ]
    with CampaignStore.create(tmp_path / "run", settings, Manifest()) as store:
        store.append(found)

    write_report(tmp_path / "run", CODE.mission, CODE.pool, write)

    summary = json.loads((tmp_path / "run" / "summary.json").read_text())
    assert summary["front"] == {
        "goals": ["g2"],
        "points": [
            {"evaluation": 1, "violations": {"g2": 2}, "faults": 1},
            {"evaluation": 0, "violations": {"g2": 4}, "faults": 3},
        ],
    }
    assert table(tmp_path / "run", "figure_harm") == [
        ["faults", "goals violated", "goals by", "violations", "violations by"],
        ["1", "1", "1", "2", "1"],
        ["3", "1", "1", "4", "0"],
    ]
    report = (tmp_path / "run" / "report.md").read_text()
    assert "## Most violations for each limit on faults (true violations, g2)\n" in report
    assert "(figures/figure_harm.png)" in report
    assert "| 3 | 1 | 1 | 4 | 0 |" in report
    assert "## Pareto front: 2 trade-offs between g2, faults (true violations)\n" in report


def test_a_ratio_over_goals_that_nobody_chose_has_its_own_front(tmp_path):
    single = write_campaign(tmp_path / "a", n_generations=3)
    other = write_campaign(tmp_path / "b", settings=FOCUS, n_generations=3)

    summaries = []
    for folder in (single, other):
        with CampaignStore.open(folder) as store:
            summaries.append(summarise(folder, store, CODE.mission, CODE.pool, "g4:g5=1:1")[0])

    of_single, of_other = summaries
    assert of_single.front is not None
    assert of_single.front.goals == ("g4", "g5")
    assert of_other.front is not None
    assert of_other.front.goals == ("g1", "g3")
    assert of_single.pick is not None
    assert of_single.pick == of_other.pick


@slow
def test_a_campaign_interrupted_in_its_first_generation_has_a_report(tmp_path):
    folder = tmp_path / "run"
    ((first, second, third, *_),) = generations_of_evaluations(1, 10)
    with CampaignStore.create(folder, FOCUS, Manifest()) as store:
        store.append([first, second, third])

    summary = write_report(folder, CODE.mission, CODE.pool, write, ratio="g3:g1=2:1")

    assert len(summary.top) == 3
    assert stems(folder / "critical", ".xmi") == ["01", "02", "03"]
    assert stems(folder / "figures", ".png") == [SINGLE[0], FRONTS[1], *TYPES]
    assert "too few for a trend" in (folder / "report.md").read_text()


def test_a_campaign_interrupted_before_its_first_evaluation_has_a_report(tmp_path):
    folder = tmp_path / "run"
    CampaignStore.create(folder, FOCUS, Manifest()).close()

    summary = write_report(folder, CODE.mission, CODE.pool, write, ratio="g3:g1=2:1")

    assert summary.top == ()
    assert stems(folder / "figures", ".png") == SINGLE[:1]
    report = (folder / "report.md").read_text()
    assert "No evaluation is recorded yet" in report
    assert "nearest to g3:g1=2:1: none, because no specification violates these goals." in report
    assert json.loads((folder / "summary.json").read_text())["best"] is None


@slow
def test_a_generation_without_survivors_is_left_out_of_the_fronts(tmp_path):
    folder = tmp_path / "run"
    with CampaignStore.create(folder, FOCUS, Manifest()) as store:
        found = evaluation(0, (1, 0, 1, 0, 0, 0))
        store.append([found])
        store.append(generations=[Generation(0, statistics([found]), (0,), "[]")])
        store.append(generations=[Generation(1, statistics([found]), (), "[]")])

    write_report(folder, CODE.mission, CODE.pool, write)

    assert table(folder, FRONTS[0]) == [
        ["generation", "evaluation", "g1", "g3"],
        ["0", "0", "1", "1"],
    ]


@slow
def test_what_an_earlier_longer_report_left_is_removed(tmp_path):
    folder = write_campaign(tmp_path / "run", n_generations=1, n_individuals=3)
    for name in ("critical/09.xmi", "figures/figure_10_front.png", "tables/old.csv"):
        (folder / name).parent.mkdir()
        (folder / name).write_text("old")
    (folder / "figures" / "mine.png").write_text("mine")

    write_report(folder, CODE.mission, CODE.pool, write)

    assert stems(folder / "critical", ".xmi") == ["01", "02", "03"]
    assert stems(folder / "figures", ".png") == [*SINGLE, *TYPES, "mine"]
    assert "old" not in stems(folder / "tables", ".csv")


def test_a_report_that_cannot_be_written_is_a_record_error(tmp_path, refused):
    folder = write_campaign(tmp_path / "run", n_generations=1)
    (folder / "figures").write_text("a file where a folder should be")

    with refused(RecordError):
        write_report(folder, CODE.mission, CODE.pool, write)


@slow
def test_what_it_says_is_shown_when_all_but_the_page_and_the_figures_is_there(tmp_path):
    folder = write_campaign(tmp_path / "run", n_generations=1)

    def files() -> set[str]:
        return {str(path.relative_to(folder)) for path in folder.rglob("*") if path.is_file()}

    seen = []
    summary = write_report(
        folder, CODE.mission, CODE.pool, write, show=lambda found: seen.append((found, files()))
    )

    figures = {f"figures/{name}{suffix}" for name in SINGLE + TYPES for suffix in (".png", ".svg")}
    last = figures | {"report.html"}
    assert seen == [(summary, files() - last)]
    assert last <= files()


@slow
def test_figures_are_drawn_though_nobody_reads_what_is_shown(tmp_path):
    folder = write_campaign(tmp_path / "run", n_generations=1)

    def unread(_: object) -> None:
        raise BrokenPipeError

    with pytest.raises(BrokenPipeError):
        write_report(folder, CODE.mission, CODE.pool, write, show=unread)

    assert stems(folder / "figures", ".png") == SINGLE + TYPES


@slow
def test_figures_that_cannot_be_written_are_a_record_error_after_the_rest(tmp_path, refused):
    folder = write_campaign(tmp_path / "run", n_generations=1)
    shown = []

    def show(summary: Summary) -> None:
        shown.append(summary)
        (folder / "figures" / f"{TYPES[-1]}.svg").mkdir()

    with refused(RecordError):
        write_report(folder, CODE.mission, CODE.pool, write, show=show)

    assert len(shown) == 1
