"""Writes what a campaign found into its folder: specifications, figures, tables, report.

References
----------
Source paper, section V, figures 5 to 12.
"""

import json
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import astuple, fields, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias

from mrsfi_runtime.analysis import tables
from mrsfi_runtime.analysis.columns import Columns
from mrsfi_runtime.analysis.drawing import Draw, Drawing, draw_here
from mrsfi_runtime.analysis.fronts import Front, Harm, Pick, find_front, thinned
from mrsfi_runtime.analysis.markdown import report_text
from mrsfi_runtime.analysis.page.content import PageEntry, campaign_page, flown_of, told_content
from mrsfi_runtime.analysis.page.document import document
from mrsfi_runtime.analysis.patterns import TypePattern
from mrsfi_runtime.analysis.summary import Summary, as_json, summarise
from mrsfi_runtime.analysis.weaknesses import broken_by, goal_in_words
from mrsfi_runtime.causes.ways import Way, least
from mrsfi_runtime.engine.recording import Record, Recording
from mrsfi_runtime.errors import EvaluationError, MrsfiError, RecordError
from mrsfi_runtime.model.faults import FaultPool, Specification, numbered
from mrsfi_runtime.model.mission import Mission
from mrsfi_runtime.record.folder import CampaignFolder
from mrsfi_runtime.record.measure import Measure
from mrsfi_runtime.record.named_faults import named_faults
from mrsfi_runtime.record.settings import CampaignSettings
from mrsfi_runtime.record.store import CampaignStore

if TYPE_CHECKING:
    from mrsfi_runtime.analysis.page.flight import Flown

N_GENERATION_FRONTS = 5


class Illustration(NamedTuple):
    """A figure and the numbers behind it; ``name`` is the stem of their files."""

    name: str
    caption: str
    drawing: Drawing
    rows: tables.Rows


SpecificationRow: TypeAlias = tuple[str, int, int, Mapping[str, float]]
"""Pool fault ID, start, finish, and values by parameter name."""

SpecificationWriter: TypeAlias = Callable[
    [Sequence[SpecificationRow], Path, str, Sequence[str]], None
]
"""Writes rows as a fault specification to a path, under an identifier, with the faults' names."""


def _unflown(_: Specification) -> Recording:
    raise EvaluationError("Nothing was flown again.")


def write_report(
    folder: Path,
    mission: Mission,
    pool: FaultPool,
    write_specification: SpecificationWriter,
    *,
    record: Record = _unflown,
    ratio: str | None = None,
    draw: Draw = draw_here,
    show: Callable[[Summary], None] = lambda _: None,
) -> Summary:
    """Write everything a person or a script wants from a campaign, finished or interrupted.

    Every file of an earlier report is replaced or removed. What the page shows is flown by
    ``record``; where that fails, the page says why. ``show`` is given what the report says once all
    but the page and the figures is written; these are finished whatever becomes of it. A ``ratio``
    is one to pick by, such as ``g3:g1=2:1``.
    """
    layout = CampaignFolder(folder)
    with CampaignStore.open(folder) as store:
        summary, columns = summarise(folder, store, mission, pool, ratio)
        with writing(folder, "report"):
            shown = tuple(illustrate(summary, mission, columns, store))
            _emptied(layout.figures, "figure_*.*", "weakness_*.*", "finding_*.*")
            _emptied(layout.tables, "*.csv")
            finish = write_figures(layout, shown, draw)
            _write_critical(layout, summary, pool, write_specification)
            _write_witnesses(layout, summary, pool, write_specification)
        try:
            with writing(folder, "flights"):
                flown = [*_fly(layout, summary, mission, pool, record)]
            summary = replace(summary, sentences={number: said for number, said, _ in flown})
            with writing(folder, "report"):
                _write_evaluations(layout.tables / "evaluations.csv", summary.measure, store)
                content = json.dumps(as_json(summary), indent=2, ensure_ascii=False)
                layout.summary.write_text(content + "\n", encoding="utf-8")
                captions = {each.name: each.caption for each in shown}
                layout.report.write_text(
                    report_text(summary, mission, pool, captions), encoding="utf-8"
                )
            show(summary)
            with writing(folder, "page"):
                page = campaign_page(
                    summary, mission, pool, store, [content for *_, content in flown]
                )
                layout.page.write_text(document(page), encoding="utf-8")
        finally:
            with writing(folder, "figures"):
                finish()
    return summary


def _fly(
    layout: CampaignFolder,
    summary: Summary,
    mission: Mission,
    pool: FaultPool,
    record: Record,
) -> Iterator[tuple[int, Sequence[str], dict[str, Any]]]:
    """Fly what is the least that breaks each goal; yield number, sentences, and what is shown."""
    shown = least(summary.ways)
    n_flights = sum(1 + len(way.faults) for way in shown)
    for way in shown:
        flown: Flown | str
        try:
            flown, sentences = flown_of(mission, pool, way, record)
        except MrsfiError as error:
            flown, sentences = str(error), ()
        told = PageEntry(
            title=goal_in_words(mission, way.goal),
            sentence=broken_by(way),
            faults=named_faults(mission, pool, way.shown.witness),
            sentences=sentences,
            outcome=summary.outcome(way),
            command=_command(layout, summary, way),
            xmi=_witness(layout, way).read_text(encoding="utf-8"),
        )
        content = told_content(mission, told, flown, n_flights)
        yield way.number, sentences, content


def _command(layout: CampaignFolder, summary: Summary, way: Way) -> Sequence[str]:
    """Return what flies a way again."""
    seed = str(summary.settings.mission_seed)
    path = str(_witness(layout, way))
    return ("mrsfi", "simulate", summary.place, "--faults", path, "--seed", seed)


def _witness(layout: CampaignFolder, way: Way) -> Path:
    kind = "-mildest" if way.is_mildest else ""
    return layout.weaknesses / f"{way.number:02d}{kind}.xmi"


@contextmanager
def writing(folder: Path, what: str) -> Iterator[None]:
    """Say of an error of the file system what could not be written."""
    try:
        yield
    except OSError as error:
        raise RecordError(
            f"{folder}: cannot write the {what}: {error}; expected a folder to write to"
        ) from error


def specification_rows(
    pool: FaultPool, specification: Specification
) -> tuple[SpecificationRow, ...]:
    """Return a specification with its values by name."""
    return tuple(
        (timed.fault, timed.start, timed.finish, pool[timed.fault].kind.named(timed.values))
        for timed in specification
    )


def _write_critical(
    layout: CampaignFolder, summary: Summary, pool: FaultPool, write: SpecificationWriter
) -> None:
    """Write the top specifications."""
    _emptied(layout.critical, "[0-9][0-9]*.xmi")
    for rank, evaluation in enumerate(summary.top, start=1):
        name = f"evaluation_{evaluation.index}"
        _write_xmi(pool, evaluation.specification, layout.critical / f"{rank:02d}.xmi", name, write)


def _write_witnesses(
    layout: CampaignFolder, summary: Summary, pool: FaultPool, write: SpecificationWriter
) -> None:
    """Write the form of each way to break a goal, and the mildest one where it is known."""
    _emptied(layout.weaknesses, "[0-9][0-9]*.xmi")
    for way in {*summary.ways, *least(summary.ways)}:
        name = f"weakness_{way.number}"
        _write_xmi(pool, way.shown.witness, _witness(layout, way), name, write)


def _write_xmi(
    pool: FaultPool, specification: Specification, path: Path, name: str, write: SpecificationWriter
) -> None:
    rows = specification_rows(pool, specification)
    write(rows, path, name, numbered(row[0] for row in rows))


def write_figures(
    layout: CampaignFolder, shown: Iterable[Illustration], draw: Draw
) -> Callable[[], None]:
    """Write the numbers behind figures and begin to draw them; what is returned waits for them."""
    for each in shown:
        (layout.tables / f"{each.name}.csv").write_bytes(tables.as_csv(each.rows))
    return draw([(each.drawing, layout.figures / each.name) for each in shown])


def _write_evaluations(path: Path, measure: Measure, store: CampaignStore) -> None:
    """Write what came of each evaluation, or of each so many-th."""
    flown = store.flown(tables.listed_step(store.n_evaluations))
    with path.open("w", encoding="utf-8", newline="") as file:
        tables.write_csv(file, tables.evaluations_table(flown, measure))


def _emptied(folder: Path, *patterns: str) -> None:
    """Make a folder, or remove from it what an earlier report left."""
    folder.mkdir(exist_ok=True)
    for pattern in patterns:
        for file in sorted(folder.glob(pattern)):
            file.unlink()


def illustrate(
    summary: Summary,
    mission: Mission,
    columns: Columns,
    store: CampaignStore,
) -> Iterator[Illustration]:
    """Yield the figures that a campaign has numbers for, in the order of the paper.

    A campaign on chosen goals gets figures 8 and 9 in place of 6 and 7, which differ in the
    fitness only; figures 10 and 11 show the first two goals of its front, whatever is minimised
    beside them.
    """
    yield Illustration(
        "figure_05_mission_map",
        "Mission map",
        map_drawing(mission),
        tables.map_table(mission),
    )
    if summary.trend.generations:
        yield from _fitness(summary)
    if summary.harm:
        yield _harm(summary.harm, summary.measure)
    if summary.front is not None and summary.front.points and len(summary.front.goals) >= 2:
        yield from _fronts(summary, summary.front.goals, columns, store)
    if summary.top:
        where = f"the {len(summary.top)} most critical specifications"
        yield _types("figure_12_fault_types", where, summary.patterns)
    if summary.ways:
        where = f"the {len(summary.ways)} least sets that break a goal"
        yield _types("figure_12_weaknesses", where, summary.guilty)


def _types(name: str, where: str, patterns: Sequence[TypePattern]) -> Illustration:
    caption = f"Fault types in {where}"
    header = tuple(field.name.removeprefix("n_") for field in fields(TypePattern))
    drawing = Drawing("fault_types", (patterns, caption))
    return Illustration(name, caption, drawing, [header, *map(astuple, patterns)])


def map_drawing(mission: Mission) -> Drawing:
    """Return the figure of a mission, which needs no evaluation."""
    return Drawing("mission_map", (mission,), "mission_plots")


def fitness_label(settings: CampaignSettings, measure: Measure) -> str:
    """Return what the fitness of a campaign measures, for an axis."""
    name = settings.fitness
    goals = " + ".join(settings.goals) or "the chosen goals"
    known = {
        "weighted": f"0.3 · {measure.words} + 0.7 · goals",
        "weighted_normalised": f"0.3 · {measure.words} + 0.7 · goals, as shares",
        "focused": f"{measure.words} of {goals}, ticks",
    }
    return f"fitness ({known.get(name, name)}{measure.means})"


def evenly_spaced(n: int, n_wanted: int) -> tuple[int, ...]:
    """Return up to ``n_wanted`` of ``0 … n - 1`` with the first, the last and equal steps."""
    if n <= n_wanted:
        return tuple(range(n))
    return tuple(step * (n - 1) // (n_wanted - 1) for step in range(n_wanted))


def _fitness(summary: Summary) -> Iterator[Illustration]:
    is_focused = summary.settings.fitness == "focused"
    mean, best = ("08", "09") if is_focused else ("06", "07")
    label = fitness_label(summary.settings, summary.measure)
    yield Illustration(
        f"figure_{mean}_mean_fitness",
        "Mean fitness of each generation",
        Drawing("mean_fitness", (summary.trend, label)),
        [
            ("generation", "mean", "std"),
            *((row.generation, row.mean, row.std) for row in summary.trend.generations),
        ],
    )
    yield Illustration(
        f"figure_{best}_best_fitness",
        "Best fitness of each generation",
        Drawing("best_fitness", (summary.trend, label)),
        [
            ("generation", "best"),
            *((row.generation, row.best) for row in summary.trend.generations),
        ],
    )


def _harm(harm: Sequence[Harm], measure: Measure) -> Illustration:
    return Illustration(
        "figure_harm",
        f"Most harm with how few {measure.minimised}",
        Drawing("harm_front", (harm, measure)),
        tables.harm_table(harm, str(measure.minimised)),
    )


def _fronts(
    summary: Summary, front_goals: tuple[str, ...], columns: Columns, store: CampaignStore
) -> Iterator[Illustration]:
    goals, measure = front_goals[:2], replace(summary.measure, minimised=None)
    over = f"over the {measure.words} of {' and '.join(goals)}{measure.means}"
    by_generation = _generation_fronts(measure, columns, store, goals)
    if by_generation:
        yield Illustration(
            "figure_10_front_by_generation",
            f"Pareto points of some generations {over}",
            Drawing("generation_fronts", (by_generation,)),
            [
                ("generation", "evaluation", *goals),
                *(
                    (generation, *row)
                    for generation, front in by_generation.items()
                    for row in tables.front_table(front)[1:]
                ),
            ],
        )
    front = find_front(measure, columns, goals)
    cloud, n_left_out = thinned(columns.of(goals))
    drawn = f"; {len(cloud)} of {len(cloud) + n_left_out} points are drawn" if n_left_out else ""
    yield Illustration(
        "figure_11_front",
        f"All non-dominated specifications {over}{drawn}",
        Drawing("whole_front", (front, cloud, _shown_pick(summary, front), n_left_out)),
        tables.front_table(front),
    )


def _generation_fronts(
    measure: Measure, columns: Columns, store: CampaignStore, goals: Sequence[str]
) -> dict[int, Front]:
    """Return the fronts of evenly spaced generations' populations, by generation."""
    populated = store.populated()
    fronts = {}
    for place in evenly_spaced(len(populated), N_GENERATION_FRONTS):
        generation = store.generation(populated[place])
        assert generation is not None
        rows = columns.distinct_among(generation.population)
        fronts[generation.index] = find_front(measure, columns, goals, rows)
    return fronts


def _shown_pick(summary: Summary, front: Front) -> Pick | None:
    """Return the pick if it is one of the front that is drawn."""
    pick = summary.pick
    if pick is None or pick.point is None or set(pick.ratio.goals) != set(front.goals):
        return None
    drawn = {point.evaluation: point for point in front.points}
    return Pick(pick.ratio, drawn.get(pick.point.evaluation), front.goals)
