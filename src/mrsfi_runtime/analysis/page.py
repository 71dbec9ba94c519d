"""The page of a campaign or a flight: its content as plain values, and one HTML file of them.

``campaign_page`` collects the content for a campaign, ``flight_page`` for one flight, and
``entry_content`` for the flight of one specification.

``document`` makes the file. It loads nothing from the network. Texts of a model or a record stay
data: they stand in JSON that cannot end its element, and the page's script inserts them as text.
The content security policy allows only that script and those styles, by hash.
"""

import json
import re
import shlex
from base64 import b64encode
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from hashlib import sha256
from importlib.resources import files
from itertools import groupby, islice
from pathlib import Path
from typing import Any

from mrsfi_runtime.analysis import story, tables, weaknesses
from mrsfi_runtime.analysis.documents import trend_in_words
from mrsfi_runtime.analysis.story import Flown
from mrsfi_runtime.analysis.summary import Summary
from mrsfi_runtime.analysis.weaknesses import GoalVerdict, State
from mrsfi_runtime.causes.harvest import Harvest
from mrsfi_runtime.causes.mildest import GoalWeakness
from mrsfi_runtime.causes.weakness import MEASURES
from mrsfi_runtime.engine.recording import Recording
from mrsfi_runtime.errors import counted
from mrsfi_runtime.glossary import TERMS
from mrsfi_runtime.model.faults import TimedFault
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


MOST_BYTES = 2_900_000
"""Size of a page up to which it has the flights of less grave weaknesses."""


def campaign_page(summary: Summary, store: CampaignStore) -> dict[str, Any]:
    """Return the page's content for a campaign, without flights."""
    caution = f"Caution: {summary.unrepeated}. " if summary.unrepeated else ""
    picked = summary.pick and f" The specification {summary.pick.in_words(summary.measure)}."
    return {
        "title": f"Campaign {summary.folder.name} on mission {summary.name}",
        "mission": story.mission_content(summary.mission),
        "first": _first_screen(summary),
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
        "faults": faults if len(faults) < MOST_BYTES / 3 else None,
        "command": shlex.join(("mrsfi", "replay", str(summary.folder), "--evaluation")),
    }


def _first_screen(summary: Summary) -> dict[str, Any] | None:
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
        "monitors": harvest.advice
        and tables.to_page(weaknesses.monitor_table(mission, harvest.advice)),
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
                "next": [(what, shlex.join(words)) for what, words in _next(summary, weakness)],
            }
            for weakness in summary.weaknesses
        ],
        "matrix": _matrix(summary, harvest) if summary.weaknesses else None,
    }


def _next(summary: Summary, weakness: GoalWeakness) -> Iterator[tuple[str, Sequence[str]]]:
    """Yield labelled commands that continue with a weakness."""
    run, number = str(summary.folder), str(weakness.number)
    simulate, reason = command_of(summary, weakness), ("--because", "REASON", "--by", "NAME")
    shown = "its mildest variant" if weakness.mildest else "it"
    yield f"Draw {shown}", ("mrsfi", "show", run, number)
    yield "Simulate it again", (*simulate, "--html", f"weakness-{number}.html")
    yield "Keep it as a test", ("mrsfi", "keep", run, "--weakness", number)
    yield "Decide on it", ("mrsfi", "decide", run, number, "accept", *reason)
    yield "Check after a fix", ("mrsfi", "check", summary.place)


def command_of(summary: Summary, weakness: GoalWeakness) -> Sequence[str]:
    """Return the command that simulates a weakness again."""
    path, seed = str(witness_of(summary, weakness)), str(summary.settings.mission_seed)
    return ("mrsfi", "simulate", summary.place, "--faults", path, "--seed", seed)


def witness_of(summary: Summary, weakness: GoalWeakness) -> Path:
    """Return the file of the variant of a weakness that is shown."""
    kind = "-mildest" if weakness.is_mildest else ""
    return CampaignFolder(summary.folder).weaknesses / f"{weakness.number:02d}{kind}.xmi"


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


_N_NAMED = 4  # faults in a sentence


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
    for some in by_status.values():
        some[_N_NAMED:] = [f"{len(some) - _N_NAMED} others"] * (len(some) > _N_NAMED)
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
        "evidence": " · ".join(replace(verdict, depth="").evidence),  # its list has it
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
    for each in "<>&\u2028\u2029":  # not with str.translate, which takes 70 ms
        data = data.replace(each, f"\\u{ord(each):04x}")
    parts = {
        "policy": f"default-src 'none'; script-src '{_hash(scripts)}'; style-src "
        f"'{_hash(styles)}'; base-uri 'none'; form-action 'none'",
        "styles": f"<style>{styles}</style>",
        "data": f'<script type="application/json" id="data">{data}</script>',
        "scripts": f"<script>{scripts}</script>",
    }
    return re.sub(r"\{\{(\w+)}}", lambda found: parts[found[1]], _asset("page.html"))


def _asset(name: str) -> str:
    return files(__package__).joinpath("assets", name).read_text(encoding="utf-8")


def _hash(text: str) -> str:
    return f"sha256-{b64encode(sha256(text.encode()).digest()).decode()}"
