"""Writes what a campaign found into its folder: specifications, figures, tables, report.

A way to break a goal is also drawn by itself: its flight in time and in space.
"""

import json
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias

from mrsfi_runtime.analysis.campaign_tables import MOST_LISTED, evaluations_table
from mrsfi_runtime.analysis.drawing import Draw, Drawing, draw_here, drawn
from mrsfi_runtime.analysis.illustrations import Illustration, illustrate
from mrsfi_runtime.analysis.latex import report_latex
from mrsfi_runtime.analysis.markdown import report_text
from mrsfi_runtime.analysis.page.content import PageEntry, campaign_page, flown_of, told_content
from mrsfi_runtime.analysis.page.document import document
from mrsfi_runtime.analysis.story import places_table, story_of, timeline_table
from mrsfi_runtime.analysis.summary import Summary, as_json, summarise
from mrsfi_runtime.analysis.table import as_csv, every, write_csv
from mrsfi_runtime.analysis.weaknesses import broken_by, goal_in_words
from mrsfi_runtime.causes.mildest import Way, least
from mrsfi_runtime.engine.recording import Record
from mrsfi_runtime.errors import MrsfiError, RecordError, UsageError
from mrsfi_runtime.model.faults import FaultPool, Specification, numbered
from mrsfi_runtime.model.mission import Mission
from mrsfi_runtime.record.database import CampaignFolder
from mrsfi_runtime.record.observers import named_faults
from mrsfi_runtime.record.store import CampaignStore

if TYPE_CHECKING:
    from mrsfi_runtime.analysis.page.flight import Flown

SpecificationRow: TypeAlias = tuple[str, int, int, Mapping[str, float], str]
"""Pool fault ID, start, finish, values by parameter name, and the ID of a trigger or nothing."""

SpecificationWriter: TypeAlias = Callable[
    [Sequence[SpecificationRow], Path, str, Sequence[str]], None
]
"""Writes rows as a fault specification to a path, under an identifier, with the faults' names."""


class Shown(NamedTuple):
    """A way to break a goal, in words and in pictures.

    ``sentences`` say by what the goal is broken, in how many forms, who sees it, and from what on,
    if that is known; then what each of the faults did until it broke. ``figures`` are PNG of the
    flight in time and in space; each is there as SVG, too.
    """

    way: Way
    title: str
    sentences: Sequence[str]
    figures: Sequence[Path]


def write_report(  # noqa: PLR0913 - most have a default
    folder: Path,
    mission: Mission,
    pool: FaultPool,
    write_specification: SpecificationWriter,
    *,
    record: Record,
    ratio: str | None = None,
    draw: Draw = draw_here,
    show: Callable[[Summary], None] = lambda _: None,
    latex: bool = False,
) -> Summary:
    """Write everything a person or a script wants from a campaign, finished or interrupted.

    Every file of an earlier report goes. What the page shows is flown by ``record``; where that
    fails, the page says why. ``show`` is given what the report says once all but the page and the
    figures is written; these are finished whatever becomes of it. A ``ratio`` is one to pick by.
    """
    layout = CampaignFolder(folder)
    with CampaignStore.open(folder) as store:
        summary, columns = summarise(folder, store, mission, pool, ratio)
        with _writing(folder, "report"):
            shown = tuple(illustrate(summary, columns, store))
            _emptied(layout.figures, "figure_*.*", "weakness_*.*", "finding_*.*")
            _emptied(layout.tables, "*.csv")
            layout.latex.unlink(missing_ok=True)
            finish = _write_figures(layout, shown, draw)
            _write_specifications(layout, summary, write_specification)
        try:
            with _writing(folder, "flights"):
                flown = [*_fly(layout, summary, record)]
            summary = replace(summary, sentences={number: said for number, said, _ in flown})
            with _writing(folder, "report"):
                listed = store.flown(every(summary.n_evaluations, MOST_LISTED))
                table = evaluations_table("Evaluations", listed, summary.measure)
                path = layout.tables / "evaluations.csv"
                with path.open("w", encoding="utf-8", newline="") as file:
                    write_csv(file, table.lines)
                content = json.dumps(as_json(summary), indent=2, ensure_ascii=False)
                layout.summary.write_text(content + "\n", encoding="utf-8")
                captions = {each.name: each.table.title for each in shown}
                layout.report.write_text(report_text(summary, captions), encoding="utf-8")
                if latex:
                    tex = report_latex(summary, shown)
                    layout.latex.write_text(tex, encoding="utf-8")
            show(summary)
            with _writing(folder, "page"):
                told = [content for *_, content in flown]
                next_of = partial(_next, layout, summary)
                page = campaign_page(summary, store, told, next_of)
                layout.page.write_text(document(page), encoding="utf-8")
        finally:
            with _writing(folder, "figures"):
                finish()
                for each in shown if latex else ():
                    path = layout.figures / f"{each.name}.pdf"
                    path.write_bytes(drawn(each.drawing, (".pdf",))[".pdf"])
    return summary


def look_at(
    layout: CampaignFolder, mission: Mission, pool: FaultPool, way: Way, record: Record
) -> Shown:
    """Fly a way to break a goal, and draw what is missing, or older than the campaign's record."""
    flown, sentences = flown_of(mission, pool, way, record)
    story = story_of(flown.title, mission, flown.faults, flown.recording)
    illustrations = [
        Illustration(
            f"weakness_{way.number:02d}_{what}",
            Drawing(f"flight_{what}", (story,), "mission_plots"),
            table(story),
        )
        for what, table in (("timeline", timeline_table), ("map", places_table))
    ]
    names = [each.name for each in illustrations]
    files = [layout.figures / f"{name}{kind}" for kind in (".png", ".svg") for name in names]
    recorded = layout.database.stat().st_mtime_ns
    if any(not file.exists() or file.stat().st_mtime_ns <= recorded for file in files):
        with _writing(layout.path, "figures"):
            for folder in (layout.tables, layout.figures):
                folder.mkdir(exist_ok=True)
            _write_figures(layout, illustrations, draw_here)()
    return Shown(way, flown.title, (broken_by(way, mission.units), *sentences), files[: len(names)])


def _fly(
    layout: CampaignFolder, summary: Summary, record: Record
) -> Iterator[tuple[int, Sequence[str], dict[str, Any]]]:
    """Fly what is the least that breaks each goal; yield number, sentences, and what is shown."""
    mission, pool, shown = summary.mission, summary.pool, least(summary.ways)
    n_flights = sum(1 + len(way.faults) for way in shown)
    for way in shown:
        flown: Flown | str
        try:
            flown, sentences = flown_of(mission, pool, way, record)
        except UsageError:  # the user's folder for temporary files is full, say
            raise
        except MrsfiError as error:
            flown, sentences = str(error), ()
        told = PageEntry(
            title=goal_in_words(mission, way.goal),
            sentence=broken_by(way, mission.units),
            faults=named_faults(mission, pool, way.shown.witness),
            sentences=sentences,
            outcome=summary.outcome(way),
            command=_command(layout, summary, way),
            xmi=_witness(layout, way).read_text(encoding="utf-8"),
        )
        content = told_content(mission, told, flown, n_flights)
        yield way.number, sentences, content


def _command(layout: CampaignFolder, summary: Summary, way: Way) -> Sequence[str]:
    seed = str(summary.settings.mission_seed)
    path = str(_witness(layout, way))
    return ("mrsfi", "simulate", summary.place, "--faults", path, "--seed", seed)


def _next(layout: CampaignFolder, summary: Summary, way: Way) -> dict[str, Sequence[str]]:
    run, number = str(layout.path), str(way.number)
    return {
        "See it": ("mrsfi", "show", run, number),
        "Fly it yourself": (*_command(layout, summary, way), "--html", f"weakness-{number}.html"),
        "Keep it as a test": ("mrsfi", "keep", run, "--weakness", number),
        "After the fix": ("mrsfi", "check", summary.place),
    }


def _witness(layout: CampaignFolder, way: Way) -> Path:
    kind = "-mildest" if way.is_mildest else ""
    return layout.weaknesses / f"{way.number:02d}{kind}.xmi"


@contextmanager
def _writing(folder: Path, what: str) -> Iterator[None]:
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
        (fault, start, finish, pool[fault].kind.named(values), trigger)
        for fault, start, finish, values, trigger in specification
    )


def _write_specifications(
    layout: CampaignFolder, summary: Summary, write: SpecificationWriter
) -> None:
    for folder in (layout.critical, layout.weaknesses):
        _emptied(folder, "[0-9][0-9]*.xmi")
    top = [
        (layout.critical / f"{rank:02d}.xmi", f"evaluation_{each.index}", each.specification)
        for rank, each in enumerate(summary.top, start=1)
    ]
    ways = [
        (_witness(layout, way), f"weakness_{way.number}", way.shown.witness)
        for way in {*summary.ways, *least(summary.ways)}
    ]
    for path, name, specification in (*top, *ways):
        rows = specification_rows(summary.pool, specification)
        write(rows, path, name, numbered(row[0] for row in rows))


def _write_figures(
    layout: CampaignFolder, shown: Iterable[Illustration], draw: Draw
) -> Callable[[], None]:
    """Write the numbers behind figures and begin to draw them; what is returned waits for them."""
    for each in shown:
        (layout.tables / f"{each.name}.csv").write_bytes(as_csv(each.table.lines))
    return draw([(each.drawing, layout.figures / each.name) for each in shown])


def _emptied(folder: Path, *patterns: str) -> None:
    """Make a folder, or remove from it what an earlier report left."""
    folder.mkdir(exist_ok=True)
    for pattern in patterns:
        for file in sorted(folder.glob(pattern)):
            file.unlink()
