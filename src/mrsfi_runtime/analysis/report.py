"""Write the report of a campaign into its folder, and the page of a campaign or a flight.

``write_report``, near the end, writes all files in their order. ``draw_weakness`` simulates and
draws one weakness in time and in space. The first half collects the page's content as plain values:
``campaign_page`` for a campaign, ``flight_page`` for one flight.

``document`` makes one HTML file of these values. It loads nothing from the network. Texts of a
model or a record stay data: they stand in JSON that cannot end its element, and the page's script
inserts them as text. The content security policy allows only that script and those styles, by hash.
"""

import json
import re
import shlex
from base64 import b64encode
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from functools import lru_cache, partial
from hashlib import sha256
from importlib.resources import files
from itertools import groupby, islice
from pathlib import Path
from typing import Any, NamedTuple, TypeAlias

from mrsfi_runtime.analysis import story, tables, weaknesses
from mrsfi_runtime.analysis.documents import report_latex, report_text, trend_in_words
from mrsfi_runtime.analysis.story import Flown
from mrsfi_runtime.analysis.summary import (
    Draw,
    Drawing,
    Illustration,
    Summary,
    as_json,
    draw_here,
    drawn,
    illustrate,
    summarise,
)
from mrsfi_runtime.analysis.weaknesses import GoalVerdict, State
from mrsfi_runtime.causes.cause_set import without
from mrsfi_runtime.causes.chain import chain, sentence
from mrsfi_runtime.causes.harvest import Harvest
from mrsfi_runtime.causes.mildest import GoalWeakness, least
from mrsfi_runtime.causes.weakness import MEASURES
from mrsfi_runtime.engine.recording import Record, Recording
from mrsfi_runtime.errors import MrsfiError, RecordError, UsageError, counted
from mrsfi_runtime.glossary import TERMS
from mrsfi_runtime.model.faults import FaultPool, Specification, TimedFault, numbered
from mrsfi_runtime.model.mission import Mission, Outcome
from mrsfi_runtime.record.database import CampaignFolder
from mrsfi_runtime.record.observers import NamedFault, named_faults
from mrsfi_runtime.record.store import CampaignStore


@dataclass(frozen=True, slots=True)
class PageEntry:
    """A simulated specification on the page; ``xmi`` is the text of its file."""

    title: str
    faults: Sequence[NamedFault]
    sentences: Sequence[str]
    outcome: Outcome
    command: Sequence[str]
    xmi: str


def flight_page(
    mission: Mission, entry: PageEntry, recording: Recording, facts: Iterable[tuple[str, Any]]
) -> dict[str, Any]:
    """Return the page's content for one flight; ``facts`` are named values of its record."""
    flown = Flown(entry.title, entry.faults, recording, {})
    return {
        "title": entry.title,
        "mission": story.mission_content(mission),
        "shown": [story.packed(entry_content(mission, entry, flown, story.stride(mission, 1)))],
        "record": list(facts),
    }


_MOST_BYTES = 3_000_000  # of a page of many weaknesses


def campaign_page(
    summary: Summary,
    store: CampaignStore,
    next_of: Callable[[GoalWeakness], Mapping[str, Sequence[str]]],
) -> dict[str, Any]:
    """Return the page's content for a campaign, without flights.

    ``next_of`` returns labelled commands.
    """
    caution = f"Caution: {summary.unrepeated}. " if summary.unrepeated else ""
    picked = summary.pick and f" The specification {summary.pick.in_words(summary.measure)}."
    return {
        "title": f"Campaign {summary.folder.name} on mission {summary.name}",
        "mission": story.mission_content(summary.mission),
        "first": _first_screen(summary, next_of),
        "search": {
            "said": f"{caution}{trend_in_words(summary.trend)}{picked or ''}".replace("`", ""),
            "charts": list(_charts(summary)),
        },
        "evaluations": _evaluations(summary, store),
        "record": list(_record(summary, store)),
    }


def _evaluations(summary: Summary, store: CampaignStore) -> dict[str, Any]:
    """Return some evaluations; ``faults`` has rows, and for each evaluation the places of its own.

    A row is of a timed fault, which many evaluations of a search have.
    """
    step = tables.every(summary.n_evaluations, 5000)  # listed at most
    listed = f"One evaluation in {step} is listed." if step > 1 else "All evaluations are listed."
    flown, places = [*store.evaluations(step=step)], dict[TimedFault, int]()
    own = [
        [places.setdefault(timed, len(places)) for timed in each.specification] for each in flown
    ]
    rows = [
        (each.name, each.fault.type, *each.timed[1:3], each.target, each.values_in_words)
        for each in named_faults(summary.mission, summary.pool, tuple(places))
    ]
    faults = story.packed({"rows": rows, "of": own})
    return {
        **tables.to_page(tables.short_evaluations_table(listed, flown, summary.measure)),
        "faults": faults if len(faults) < _MOST_BYTES / 3 else None,
        "command": shlex.join(("mrsfi", "replay", str(summary.folder), "--evaluation")),
    }


def _first_screen(
    summary: Summary, next_of: Callable[[GoalWeakness], Mapping[str, Sequence[str]]]
) -> dict[str, Any] | None:
    harvest, mission, pool = summary.harvest, summary.mission, summary.pool
    if harvest is None:
        return None
    headline, *facts = summary.highlights
    names = {each.goal: each.name for each in summary.verdicts}
    guilty = {fault for each in summary.weaknesses for fault in each.faults}
    about = (
        f"Campaign {summary.folder.name} on mission {summary.name}",
        counted(len(mission.robots), "robots"),
        f"{len(guilty)} of {counted(len(pool), 'faults')} in a weakness",
        counted(summary.n_evaluations + harvest.n_flights, "flights"),
    )
    return {
        "headline": headline,
        "about": " · ".join(about),
        "facts": facts,
        "goals": [_goal(summary, each) for each in summary.verdicts],
        "ways": [
            {
                "number": weakness.number,
                "goal": weakness.goal,
                "name": names[weakness.goal],
                "said": weaknesses.sentence(mission, pool, weakness),
                "sure": weaknesses.evidence(weakness),
                "mildest": weakness.mildest and weakness.mildest.sentence,
                "class": _class_of(weakness),
                "status": _status(summary, weakness),
                "share": weakness.shown.share,
                "joint": len(weakness.faults) > 1,
                "next": [(what, shlex.join(words)) for what, words in next_of(weakness).items()],
            }
            for weakness in summary.weaknesses
        ],
        "matrix": _matrix(summary, harvest) if summary.weaknesses else None,
    }


def _class_of(weakness: GoalWeakness) -> str:
    """Return how the collective intelligence detects a weakness, in its worst variant."""
    if weakness.shown.column.kind == MEASURES[0]:
        return "alarm"
    detected = weakness.shown.detection
    return "unknown" if detected is None else detected.worst.replace(" ", "-")


def _status(summary: Summary, weakness: GoalWeakness) -> str:
    """Return since when a weakness is known, and the decision on it."""
    since = summary.since.get(weakness.number)
    known = f"known since {since}, " if since else ""
    return known + summary.decided.get(weakness.number, "no decision")


def _known(summary: Summary, verdict: GoalVerdict) -> Sequence[str]:
    """Return the status of a broken goal's main weakness, and of other single undetected faults."""
    if verdict.weakness is None or verdict.state > State.VIOLATED:
        return ()
    main, by_status = verdict.weakness, dict[str, list[str]]()
    for each in summary.weaknesses:
        is_other = each.goal == main.goal and each.number != main.number
        if is_other and len(each.faults) == 1 and each.is_undetected:
            (_, owner), what = weaknesses.owner_of(summary.mission, summary.pool[each.faults[0]])
            fault = f"{owner} {what} ({each.faults[0]})"
            by_status.setdefault(_status(summary, each), []).append(fault)
    status, also = _status(summary, main), "Also undetected" if main.is_undetected else "Undetected"
    others = (f"{also} under {' or '.join(some)}: {how}." for how, some in by_status.items())
    return [f"{status[:1].upper()}{status[1:]}.", *others]


def _goal(summary: Summary, verdict: GoalVerdict) -> dict[str, Any]:
    weakness = verdict.weakness
    return {
        "id": verdict.goal,
        "name": verdict.name,
        "state": verdict.words,
        "mark": "×!!?✓"[verdict.state],
        "grave": verdict.state <= State.VIOLATED,
        "cause": verdict.cause,
        "detection": verdict.detection,
        "stakes": verdict.stakes,
        "known": _known(summary, verdict),
        "evidence": " · ".join(verdict.evidence),
        "number": None if weakness is None else weakness.number,
    }


def _matrix(summary: Summary, known: Harvest) -> dict[str, Any]:
    mission, pool = summary.mission, summary.pool
    guilty = {fault for each in summary.weaknesses for fault in each.faults}
    owned = [(*weaknesses.owner_of(mission, fault), fault) for fault in pool if fault.id in guilty]
    owned.sort(key=lambda each: each[0])
    last = sorted(
        summary.weaknesses,  # the gravest last, of these the smallest
        key=lambda each: (each.shown.column.kind != MEASURES[0], -len(each.faults)),
    )
    cells = {(each.goal, fault): each.number for each in last for fault in each.faults}
    owners = groupby(owned, key=lambda each: each[0])
    return {
        "owners": [{"name": name, "n": len([*some])} for (_, name), some in owners],
        "faults": [
            {"label": f"{fault.id} {what}", "title": f"{fault.id}: {fault.words}"}
            for _, what, fault in owned
        ],
        "rows": [
            {
                "id": each.goal,
                "name": each.name,
                "cells": [cells.get((each.goal, fault.id)) for *_, fault in owned],
            }
            for each in summary.verdicts
            if each.weakness is not None
        ],
        "note": f"{weaknesses.harmless(pool, known)}.",
    }


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


def entry_content(
    mission: Mission, entry: PageEntry, flown: Flown | str, stride: int
) -> dict[str, Any]:
    """Return the page's content for a specification, with its flight or why that is missing."""
    flight, reason = None, flown
    if isinstance(flown, Flown):
        flight, reason = story.flight_content(mission, flown, stride), ""
    faults = tables.fault_table("", entry.faults, entry.outcome)
    nearest = tables.nearest_in_words(mission, entry.outcome)
    sentences = entry.sentences or [""] * len(entry.faults)
    columns = (*faults.columns, "effect")
    rows = [(*row, did) for row, did in zip(faults.rows, sentences, strict=True)]
    return {
        "title": entry.title,
        "faults": tables.to_page(replace(faults, columns=columns, rows=rows)),
        "counts": tables.to_page(
            tables.goal_table(f"{tables.COUNTS} {nearest}".rstrip(), mission, entry.outcome)
        ),
        "command": shlex.join(entry.command),
        "xmi": entry.xmi,
        "flight": flight,
        "no_flight": reason,
    }


def _charts(summary: Summary) -> Iterable[dict[str, Any]]:
    rows = summary.trend.generations
    if rows:
        lines = {"best": [row.best for row in rows], "mean": [row.mean for row in rows]}
        xs = [row.generation for row in rows]
        yield _chart("Fitness of each generation", "generation", "fitness", xs, lines)
    front = summary.front
    if front is not None and front.points and len(front.goals) > 1:
        x, y, *_ = front.goals
        points = sorted(point.violations[:2] for point in front.points)
        yield _scatter("Pareto front, violations in ticks", x, y, points)
    if summary.harm:
        harm = sorted((each.cost, each.violations) for each in summary.harm)
        words = f"Most violations for each limit on {summary.measure.minimised}"
        yield _scatter(words, str(summary.measure.minimised), "violations", harm)


def _scatter(title: str, x: str, y: str, points: Sequence[Sequence[float]]) -> dict[str, Any]:
    xs, values = zip(*points, strict=True)
    return _chart(title, x, y, xs, {y: values}) | {"points": True}


def _chart(
    title: str, x: str, y: str, xs: Sequence[float], lines: Mapping[str, Sequence[float]]
) -> dict[str, Any]:
    series = [{"label": label, "values": values} for label, values in lines.items()]
    return {"title": title, "x": x, "y": y, "xs": xs, "lines": series}


def _record(summary: Summary, store: CampaignStore) -> Iterable[tuple[str, Any]]:
    manifest = store.manifest
    yield from {
        "campaign": summary.folder.name,
        "mission": summary.name,
        "case": manifest.case,
        "engine": manifest.engine.name,
        "generations": summary.n_generations,
        "evaluations": summary.counted.rpartition(" ")[0],
        "distinct specifications": summary.n_distinct,
        "evaluations with an error": summary.n_failures,
        "semantics": summary.semantics,
        "digest": summary.digest,
    }.items()
    yield from ((f"version of {name}", text) for name, text in manifest.versions.items())
    yield from (
        (f"setting {name}", text) for name, text in tables.settings_table(summary.settings).rows
    )
    yield from ((f"SHA-256 of {name}", text) for name, text in islice(manifest.sha256.items(), 100))


_ALSO = {
    "break": "breaks",
    "broken": "breaks",
    "CI": "collective intelligence",
    "closest approach": "margin",
    "detect": "detected",
    "failed": "fails",
    "in belief": "believed",
    "in truth": "true",
    "masked": "undetected",
    "missed": "fails",
    "phantom": "false alarm",
    "specification": "fault specification",
}
"""Other words for terms of the glossary."""


def meanings() -> dict[str, str]:
    """Return the tooltips of the page: the meaning of each term, by the words for it."""
    found = {each.name: each.meaning.replace("`", "") for each in TERMS}
    return found | {word: found[name] for word, name in _ALSO.items()}


def document(content: Mapping[str, Any]) -> str:
    """Return the page as HTML; ``content`` has the plain values that ``page.js`` reads."""
    styles = "\n".join(map(_asset, ("uPlot.css", "page.css")))
    names = ("uPlot.js", "build.js", "flight.js", "screen.js", "page.js")
    scripts = "\n".join(map(_asset, names))
    shown = {**content, "terms": meanings()}
    data = json.dumps(shown, ensure_ascii=False, separators=(",", ":"), allow_nan=False)
    safe = data.translate({ord(each): f"\\u{ord(each):04x}" for each in "<>&\u2028\u2029"})
    parts = {
        "policy": f"default-src 'none'; script-src '{_hash(scripts)}'; style-src "
        f"'{_hash(styles)}'; base-uri 'none'; form-action 'none'",
        "styles": f"<style>{styles}</style>",
        "data": f'<script type="application/json" id="data">{safe}</script>',
        "scripts": f"<script>{scripts}</script>",
    }
    return re.sub(r"\{\{(\w+)}}", lambda found: parts[found[1]], _asset("page.html"))


def _asset(name: str) -> str:
    return files(__package__).joinpath("assets", name).read_text(encoding="utf-8")


def _hash(text: str) -> str:
    return f"sha256-{b64encode(sha256(text.encode()).digest()).decode()}"


SpecificationRow: TypeAlias = tuple[str, int, int, Mapping[str, float], str]
"""Fault ID, start, finish, values by parameter name, and the trigger's ID or an empty text."""

SpecificationWriter: TypeAlias = Callable[
    [Sequence[SpecificationRow], Path, str, Sequence[str]], None
]
"""Writes rows as a fault specification to a path, with its identifier and the faults' names."""


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
    draw: Draw = draw_here,
    show: Callable[[Summary], None] = lambda _: None,
    latex: bool = False,
    decided: Callable[[GoalWeakness], str] = lambda _: "",
    since: Callable[[GoalWeakness], str] = lambda _: "",
) -> Summary:
    """Write all files of a report on a campaign, finished or interrupted.

    Files of an earlier report are removed. ``record`` simulates the flights of the page; if it
    fails, the page gives the reason. ``show`` gets the summary when all files but the page and the
    figures are written; the figures are finished even if it fails. ``ratio`` is one to pick by.
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
            finish = _write_figures(layout, shown, draw)
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
                captions = {each.name: each.table.title for each in shown}
                layout.report.write_text(report_text(summary, captions), encoding="utf-8")
                if latex:
                    layout.latex.write_text(report_latex(summary, shown), encoding="utf-8")
            show(summary)
            with _writing(folder, "page"):
                page = campaign_page(summary, store, partial(_next, layout, summary))
            with _writing(folder, "flights"):
                page |= _flights(layout, summary, fly, _MOST_BYTES - len(document(page)))
            with _writing(folder, "page"):
                layout.page.write_text(document(page), encoding="utf-8")
        finally:
            with _writing(folder, "figures"):
                finish()
                for each in shown if latex else ():
                    path = layout.figures / f"{each.name}.pdf"
                    path.write_bytes(drawn(each.drawing, (".pdf",))[".pdf"])
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
            Drawing(f"flight_{what}", (scene,), "mission_plots"),
            table(scene),
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
            _write_figures(layout, illustrations, draw_here)()
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


def _flights(
    layout: CampaignFolder, summary: Summary, record: Record, n_left: int
) -> dict[str, Any]:
    """Return the flights of weaknesses by number, in at most ``n_left`` bytes.

    The main weakness of each goal has one in any case. The others come by how grave they are.
    """
    mission, weaknesses = summary.mission, summary.weaknesses
    first = {each.weakness.number for each in summary.verdicts if each.weakness}
    n_flights = sum(1 + len(each.faults) for each in weaknesses if each.number in first)
    stride, fault_free = story.stride(mission, n_flights), None
    with suppress(MrsfiError):
        fault_free = story.packed(story.motion(mission, record(()), stride)) if first else None
    n_left -= len(fault_free or "")

    def rank(weakness: GoalWeakness) -> tuple[bool, int, bool]:
        kind = MEASURES.index(weakness.shown.column.kind)
        return weakness.number not in first, -kind, not weakness.is_undetected

    shown: dict[int, str] = {}
    for weakness in sorted(weaknesses, key=rank):
        flown, sentences = _flown(summary, weakness, record)
        entry = PageEntry(
            title=f"{mission.label_of(weakness.goal)}, weakness {weakness.number}",
            faults=named_faults(mission, summary.pool, weakness.shown.witness),
            sentences=sentences,
            outcome=summary.outcome(weakness),
            command=_command(layout, summary, weakness),
            xmi=_witness(layout, weakness).read_text(encoding="utf-8"),
        )
        text = story.packed(entry_content(mission, entry, flown, stride))
        n_left -= len(text)
        if n_left < 0 and weakness.number not in first:
            break
        shown[weakness.number] = text
    return {"shown": shown, "fault_free": fault_free}


def _command(layout: CampaignFolder, summary: Summary, weakness: GoalWeakness) -> Sequence[str]:
    path, seed = str(_witness(layout, weakness)), str(summary.settings.mission_seed)
    return ("mrsfi", "simulate", summary.place, "--faults", path, "--seed", seed)


def _next(
    layout: CampaignFolder, summary: Summary, weakness: GoalWeakness
) -> dict[str, Sequence[str]]:
    run, number = str(layout.path), str(weakness.number)
    command = _command(layout, summary, weakness)
    return {
        "Draw its mildest variant" if weakness.mildest else "Draw it": (
            *("mrsfi", "show", run),
            number,
        ),
        "Simulate it again": (*command, "--html", f"weakness-{number}.html"),
        "Keep it as a test": ("mrsfi", "keep", run, "--weakness", number),
        "Decide on it": (
            *("mrsfi", "decide", run, number, "accept"),
            *("--because", "REASON", "--by", "NAME"),
        ),
        "Check after a fix": ("mrsfi", "check", summary.place),
    }


def _witness(layout: CampaignFolder, weakness: GoalWeakness) -> Path:
    kind = "-mildest" if weakness.is_mildest else ""
    return layout.weaknesses / f"{weakness.number:02d}{kind}.xmi"


@contextmanager
def _writing(folder: Path, what: str) -> Iterator[None]:
    """Name in an error of the file system what could not be written."""
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
    witnesses = [
        (_witness(layout, weakness), f"weakness_{weakness.number}", weakness.shown.witness)
        for weakness in {*summary.weaknesses, *least(summary.weaknesses)}
    ]
    for path, name, specification in (*top, *witnesses):
        rows = specification_rows(summary.pool, specification)
        write(rows, path, name, numbered(row[0] for row in rows))


def _write_figures(
    layout: CampaignFolder, shown: Iterable[Illustration], draw: Draw
) -> Callable[[], None]:
    """Write the figures' numbers and begin to draw; the returned function waits for the end."""
    for each in shown:
        (layout.tables / f"{each.name}.csv").write_bytes(tables.as_csv(each.table.lines))
    return draw([(each.drawing, layout.figures / each.name) for each in shown])


def _emptied(folder: Path, *patterns: str) -> None:
    """Make a folder, or remove the files of an earlier report from it."""
    folder.mkdir(exist_ok=True)
    for pattern in patterns:
        for file in sorted(folder.glob(pattern)):
            file.unlink()
