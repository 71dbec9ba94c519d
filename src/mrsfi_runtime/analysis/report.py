"""Write the report of a campaign into its folder.

``write_report`` writes all files in their order, the page with the flights of its weaknesses last.
``draw_weakness`` simulates and draws one weakness in time and in space.
"""

import json
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import Any, NamedTuple, TypeAlias

from mrsfi_runtime.analysis import story, tables, weaknesses
from mrsfi_runtime.analysis.documents import report_latex, report_text
from mrsfi_runtime.analysis.page import (
    MOST_BYTES,
    PageEntry,
    campaign_page,
    command_of,
    document,
    entry_content,
    witness_of,
)
from mrsfi_runtime.analysis.story import Flown
from mrsfi_runtime.analysis.summary import Illustration, Summary, as_json, illustrate, summarise
from mrsfi_runtime.causes.cause_set import without
from mrsfi_runtime.causes.chain import chain, sentence
from mrsfi_runtime.causes.mildest import GoalWeakness, gravity, least
from mrsfi_runtime.engine.recording import Record
from mrsfi_runtime.errors import MrsfiError, RecordError, UsageError
from mrsfi_runtime.model.faults import FaultPool, Specification
from mrsfi_runtime.model.mission import Mission
from mrsfi_runtime.record.database import CampaignFolder
from mrsfi_runtime.record.observers import named_faults
from mrsfi_runtime.record.store import CampaignStore


def flown_of(
    mission: Mission, pool: FaultPool, weakness: GoalWeakness, record: Record
) -> tuple[Flown, tuple[str, ...]]:
    """Simulate a weakness, then without each of its faults; describe the effect of each fault."""
    witness, others, effects = weakness.shown.witness, {}, []
    faults, flight = named_faults(mission, pool, witness), record(witness)
    for place, fault in enumerate(faults):
        twin = record(without(witness, place))
        linked = chain(mission, flight, twin)
        verdicts = tuple(each for each in linked.verdicts if each.goal == weakness.goal)
        effects.append(sentence(mission, fault, replace(linked, verdicts=verdicts)))
        others[place] = twin
    title, since = mission.label_of(weakness.goal), weakness.shown.since or 0
    return Flown(title, faults, flight, others, weakness.goal, since), tuple(effects)


SpecificationWriter: TypeAlias = Callable[
    [FaultPool, Specification, Path, str, Sequence[str] | None], None
]
"""Writes timed faults of a pool to a path, with an identifier and names, if not ``numbered``."""


class Shown(NamedTuple):
    """A weakness in sentences and figures.

    The first of ``sentences`` describes faults, evidence, detection, and the mildest variant if it
    is known. The others describe the effect of each fault. ``figures`` are PNG files of the flight
    in time and in space; an SVG file stands beside each.
    """

    weakness: GoalWeakness
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
    show: Callable[[Summary], None] = lambda _: None,
    draws: bool = True,
    latex: bool = False,
    decided: Callable[[GoalWeakness], str] = lambda _: "",
    since: Callable[[GoalWeakness], str] = lambda _: "",
) -> Summary:
    """Write all files of a report on a campaign, finished or interrupted.

    Files of an earlier report are removed. ``record`` simulates the flights of the page; if it
    fails, the page gives the reason. ``show`` gets the summary when all files but the page and the
    figures are written; the figures are drawn even if it fails. Without ``draws`` there are only
    their numbers, in tables. ``ratio`` is one to pick by.
    ``decided`` returns the decision on a weakness in words, ``since`` the day since when it is
    known.
    """
    layout = CampaignFolder(folder)
    with CampaignStore.open(folder) as store:
        summary, columns = summarise(folder, store, mission, pool, ratio)
        words = {each.number: decided(each) for each in summary.weaknesses}
        summary = replace(summary, decided={number: each for number, each in words.items() if each})
        summary = replace(summary, since={each.number: since(each) for each in summary.weaknesses})
        with _writing(folder, "report"):
            shown = tuple(illustrate(summary, columns, store))
            _emptied(layout.figures, "figure_*.*", "weakness_*.*", "finding_*.*")
            _emptied(layout.tables, "*.csv")
            layout.latex.unlink(missing_ok=True)
            _write_tables(layout, shown)
            _write_specifications(layout, summary, write_specification)
        fly = lru_cache(4)(record)  # most weaknesses have one fault, and share the other flight
        try:
            with _writing(folder, "flights"):
                told = {
                    each.number: _flown(summary, each, fly)[1] for each in least(summary.weaknesses)
                }
            summary = replace(summary, sentences=told)
            with _writing(folder, "report"):
                listed = store.flown(tables.every(summary.n_evaluations, tables.MOST_LISTED))
                table = tables.evaluations_table("Evaluations", listed, summary.measure)
                path = layout.tables / "evaluations.csv"
                with path.open("w", encoding="utf-8", newline="") as file:
                    tables.write_csv(file, table.lines)
                content = json.dumps(as_json(summary), indent=2, ensure_ascii=False)
                layout.summary.write_text(content + "\n", encoding="utf-8")
                captions = {each.name: each.table.title for each in shown if draws}
                layout.report.write_text(report_text(summary, captions), encoding="utf-8")
                if latex:
                    layout.latex.write_text(report_latex(summary, shown), encoding="utf-8")
            show(summary)
            with _writing(folder, "page"):
                page = campaign_page(summary, store)
            with _writing(folder, "flights"):
                engine = store.manifest.engine
                is_ours = not engine.is_foreign  # others may fly for minutes
                n_left = MOST_BYTES - len(document(page)) if is_ours else 0
                page |= _flights(summary, fly, n_left)
            with _writing(folder, "page"):
                layout.page.write_text(document(page), encoding="utf-8")
        finally:
            with _writing(folder, "figures"):
                for each in shown if draws else ():
                    each.save(layout.figures)
                for each in shown if latex else ():
                    each.save(layout.figures, (".pdf",))
    return summary


def draw_weakness(
    layout: CampaignFolder,
    mission: Mission,
    pool: FaultPool,
    weakness: GoalWeakness,
    record: Record,
) -> Shown:
    """Simulate a weakness; draw its figures if missing or older than the campaign's record."""
    flown, sentences = flown_of(mission, pool, weakness, record)
    scene = story.story_of(flown.title, mission, flown.faults, flown.recording)
    illustrations = [
        Illustration(
            f"weakness_{weakness.number:02d}_{what}",
            table(scene),
            f"flight_{what}",
            (scene,),
        )
        for what, table in (("timeline", story.timeline_table), ("map", story.places_table))
    ]
    kinds = (".png", ".svg")
    files = [layout.figures / f"{each.name}{kind}" for kind in kinds for each in illustrations]
    recorded = layout.database.stat().st_mtime_ns
    if any(not file.exists() or file.stat().st_mtime_ns <= recorded for file in files):
        with _writing(layout.path, "figures"):
            for folder in (layout.tables, layout.figures):
                folder.mkdir(exist_ok=True)
            _write_tables(layout, illustrations)
            for each in illustrations:
                each.save(layout.figures)
    described = (weaknesses.broken_by(weakness, mission.units), *sentences)
    return Shown(weakness, flown.title, described, files[: len(illustrations)])


def _flown(
    summary: Summary, weakness: GoalWeakness, record: Record
) -> tuple[Flown | str, tuple[str, ...]]:
    """Simulate a weakness; return its flights and the effects of its faults, or why it has none."""
    try:
        return flown_of(summary.mission, summary.pool, weakness, record)
    except UsageError:  # such as a full folder for temporary files
        raise
    except MrsfiError as error:
        return str(error), ()


def _flights(summary: Summary, record: Record, n_left: int) -> dict[str, Any]:
    """Return the flights of weaknesses by number, as long as some of ``n_left`` bytes are left.

    The main weakness of each goal has one in any case. The others come by how grave they are.
    """
    mission, weaknesses = summary.mission, summary.weaknesses
    first = {each.weakness.number for each in summary.verdicts if each.weakness}
    n_flights = sum(1 + len(each.faults) for each in weaknesses if each.number in first)
    stride, fault_free = story.stride(mission, n_flights), None
    with suppress(MrsfiError):
        fault_free = story.packed(story.motion(mission, record(()), stride)) if first else None
    n_left -= len(fault_free or "")

    grave = gravity(mission)

    def rank(weakness: GoalWeakness) -> tuple[bool, int, int, bool, int]:
        return weakness.number not in first, *grave(weakness)

    shown: dict[int, str] = {}
    for weakness in sorted(weaknesses, key=rank):
        if n_left <= 0 and weakness.number not in first:
            break
        flown, sentences = _flown(summary, weakness, record)
        entry = PageEntry(
            title=f"{mission.label_of(weakness.goal)}, weakness {weakness.number}",
            faults=named_faults(mission, summary.pool, weakness.shown.witness),
            sentences=sentences,
            outcome=summary.outcome(weakness),
            command=command_of(summary, weakness),
            xmi=witness_of(summary, weakness).read_text(encoding="utf-8"),
        )
        shown[weakness.number] = story.packed(entry_content(mission, entry, flown, stride))
        n_left -= len(shown[weakness.number])
    return {"shown": shown, "fault_free": fault_free}


@contextmanager
def _writing(folder: Path, what: str) -> Iterator[None]:
    """Name in an error of the file system what could not be written."""
    try:
        yield
    except OSError as error:
        raise RecordError(
            f"{folder}: cannot write the {what}: {error}; expected a folder to write to"
        ) from error


def _write_specifications(
    layout: CampaignFolder, summary: Summary, write: SpecificationWriter
) -> None:
    for folder in (layout.critical, layout.weaknesses):
        _emptied(folder, "[0-9][0-9]*.xmi")
    top = [
        (layout.critical / f"{rank:02d}.xmi", f"evaluation_{each.index}", each.specification)
        for rank, each in enumerate(summary.top, start=1)
    ]
    witnesses = [
        (witness_of(summary, weakness), f"weakness_{weakness.number}", weakness.shown.witness)
        for weakness in {*summary.weaknesses, *least(summary.weaknesses)}
    ]
    for path, name, specification in (*top, *witnesses):
        write(summary.pool, specification, path, name, None)


def _write_tables(layout: CampaignFolder, shown: Iterable[Illustration]) -> None:
    for each in shown:
        (layout.tables / f"{each.name}.csv").write_bytes(tables.as_csv(each.table.lines))


def _emptied(folder: Path, *patterns: str) -> None:
    """Make a folder, or remove the files of an earlier report from it."""
    folder.mkdir(exist_ok=True)
    for pattern in patterns:
        for file in sorted(folder.glob(pattern)):
            file.unlink()
