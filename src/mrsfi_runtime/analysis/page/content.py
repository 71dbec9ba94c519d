"""What the page shows of a campaign, or of one flight, as plain values."""

import shlex
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import groupby, islice
from typing import Any

from mrsfi_runtime.analysis.campaign_tables import (
    COUNTS,
    fault_table,
    goal_table,
    nearest_in_words,
    settings_table,
    short_evaluations_table,
)
from mrsfi_runtime.analysis.markdown import trend_in_words
from mrsfi_runtime.analysis.page.flight import (
    Flown,
    flight_content,
    mission_content,
    stride,
)
from mrsfi_runtime.analysis.summary import Summary
from mrsfi_runtime.analysis.table import every, to_page
from mrsfi_runtime.analysis.verdicts import (
    GoalVerdict,
    State,
    cause_in_words,
    owner_of,
)
from mrsfi_runtime.analysis.weaknesses import detection, goal_in_words, harmless, verdict
from mrsfi_runtime.causes.cause_set import without
from mrsfi_runtime.causes.chain import chain, sentence
from mrsfi_runtime.causes.mildest import Way, least
from mrsfi_runtime.engine.recording import Record, Recording
from mrsfi_runtime.errors import counted
from mrsfi_runtime.model.faults import FaultPool
from mrsfi_runtime.model.mission import Mission, Outcome
from mrsfi_runtime.record.observers import NamedFault, named_faults
from mrsfi_runtime.record.store import CampaignStore

MOST_LISTED = 5000
"""Evaluations that the page lists, at most."""

_MARKS = dict(zip(State, "×!!?✓", strict=True))
"""What stands for the state of a goal."""


@dataclass(frozen=True, slots=True)
class PageEntry:
    """What the page says of a specification that was flown; ``xmi`` is that as a file holds it."""

    title: str
    sentence: str
    faults: Sequence[NamedFault]
    sentences: Sequence[str]
    outcome: Outcome
    command: Sequence[str]
    xmi: str


def flight_page(
    mission: Mission, told: PageEntry, recording: Recording, facts: Iterable[tuple[str, Any]]
) -> dict[str, Any]:
    """Return what the page shows of one flight; ``facts`` are named values of its record."""
    flown = Flown(told.title, told.faults, recording, {})
    return {
        "title": told.title,
        "mission": mission_content(mission),
        "heading": "What flew",
        "shown": [told_content(mission, told, flown, 1)],
        "record": list(facts),
    }


def campaign_page(
    summary: Summary,
    store: CampaignStore,
    shown: Sequence[dict[str, Any]],
    next_of: Callable[[Way], Mapping[str, Sequence[str]]],
) -> dict[str, Any]:
    """Return what the page shows of a campaign; ``next_of`` has commands by what they do."""
    step = every(summary.n_evaluations, MOST_LISTED)
    listed = f"One in {step} is listed." if step > 1 else "All are listed."
    evaluations = short_evaluations_table(listed, store.flown(step), summary.measure)
    return {
        "title": f"Campaign {summary.folder.name} on mission {summary.name}",
        "mission": mission_content(summary.mission),
        "first": _first_screen(summary, next_of),
        "heading": "The least that breaks each goal, as it was flown",
        "shown": list(shown),
        "search": {"said": _searched_in_words(summary), "charts": list(_charts(summary))},
        "evaluations": to_page(evaluations),
        "record": list(_record(summary, store)),
    }


def _first_screen(
    summary: Summary, next_of: Callable[[Way], Mapping[str, Sequence[str]]]
) -> dict[str, Any] | None:
    known, mission, pool = summary.harvest, summary.mission, summary.pool
    if known is None:
        return None
    headline, *facts = summary.said
    told = least(summary.ways)
    places = {way.number: place for place, way in enumerate(told)}
    names = {each.goal: each.name for each in summary.verdicts}
    shown = {way.number: way for way in (*summary.ways, *told)}
    guilty = {fault for way in summary.ways for fault in way.faults}
    n_flights = summary.n_evaluations + known.n_flights
    about = (
        f"Campaign {summary.folder.name} on mission {summary.name}",
        counted(len(mission.robots), "robots"),
        f"{len(guilty)} of {counted(len(pool), 'faults')} break a goal",
        counted(n_flights, "flights"),
    )
    return {
        "headline": headline,
        "about": " · ".join(about),
        "facts": facts,
        "goals": [*map(_goal, summary.verdicts)],
        "ways": [
            {
                "number": way.number,
                "goal": way.goal,
                "name": names[way.goal],
                "said": f"{names[way.goal]} breaks if {cause_in_words(mission, pool, way)}; "
                f"{detection(way, mission.units)}",
                "sure": verdict(way, mission.units),
                "kind": way.shown.column.kind,
                "unseen": way.is_undetected,
                "share": way.shown.share,
                "joint": len(way.faults) > 1,
                "shown": places.get(way.number),
                "next": [(what, shlex.join(words)) for what, words in next_of(way).items()],
            }
            for way in shown.values()
        ],
        "matrix": _matrix(summary) if summary.ways else None,
    }


def _goal(each: GoalVerdict) -> dict[str, Any]:
    way = each.way
    return {
        "id": each.goal,
        "name": each.name,
        "state": each.words,
        "mark": _MARKS[each.state],
        "grave": each.state <= State.VIOLATED,
        "cause": each.cause,
        "by": "" if way is None else " and ".join(way.faults),
        "detection": each.detection,
        "sure": each.sure,
        "others": f"{counted(each.n_others, 'ways')} more" if each.n_others else "",
        "unknown": each.unknown,
        "number": None if way is None else way.number,
    }


def _matrix(summary: Summary) -> dict[str, Any]:
    mission, pool = summary.mission, summary.pool
    guilty = {fault for way in summary.ways for fault in way.faults}
    owned = [(*owner_of(mission, fault), fault) for fault in pool if fault.id in guilty]
    owned.sort(key=lambda each: each[0])
    fewest = sorted(summary.ways, key=lambda way: -len(way.faults))  # which replace the others
    cells = {(way.goal, fault): way.number for way in fewest for fault in way.faults}
    return {
        "owners": [
            {"name": name, "n": sum(1 for _ in some)}
            for (_, name), some in groupby(owned, key=lambda each: each[0])
        ],
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
            if each.way is not None
        ],
        "note": f"{harmless(pool, summary.ways)}.",
    }


def flown_of(
    mission: Mission, pool: FaultPool, way: Way, record: Record
) -> tuple[Flown, tuple[str, ...]]:
    """Fly what breaks a goal, and all of its faults but each; say what each did until it broke."""
    faults = named_faults(mission, pool, way.shown.witness)
    flight, others, said = record(way.shown.witness), {}, []
    for place, fault in enumerate(faults):
        twin = record(without(way.shown.witness, place))
        linked = chain(mission, flight, twin)
        verdicts = tuple(each for each in linked.verdicts if each.goal == way.goal)
        said.append(sentence(fault, replace(linked, verdicts=verdicts)))
        others[place] = twin
    title, since = goal_in_words(mission, way.goal), way.shown.since or 0
    return Flown(title, faults, flight, others, way.goal, since), tuple(said)


def told_content(
    mission: Mission, told: PageEntry, flown: Flown | str, n_flights: int
) -> dict[str, Any]:
    """Return what the page shows of what was flown, and of its flight or why it has none."""
    flight, reason = None, flown
    if isinstance(flown, Flown):
        flight, reason = flight_content(mission, flown, stride(mission, n_flights)), ""
    faults = fault_table("", told.faults, told.outcome)
    nearest = nearest_in_words(mission, told.outcome)
    sentences = told.sentences or [""] * len(told.faults)
    return {
        "title": told.title,
        "sentence": told.sentence,
        "faults": to_page(
            replace(
                faults,
                columns=(*faults.columns, "what it did"),
                rows=[(*row, did) for row, did in zip(faults.rows, sentences, strict=True)],
            )
        ),
        "counts": to_page(goal_table(f"{COUNTS} {nearest}".rstrip(), mission, told.outcome)),
        "command": shlex.join(told.command),
        "xmi": told.xmi,
        "flight": flight,
        "no_flight": reason,
    }


def _searched_in_words(summary: Summary) -> str:
    caution = f"Caution: {summary.unrepeated}. " if summary.unrepeated else ""
    picked = summary.pick and f" The specification {summary.pick.in_words(summary.measure)}."
    return f"{caution}{trend_in_words(summary.trend)}{picked or ''}"


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
        words = f"Most violations with how few {summary.measure.minimised}"
        yield _scatter(words, str(summary.measure.minimised), "violations", harm)


def _scatter(title: str, x: str, y: str, points: Sequence[Sequence[float]]) -> dict[str, Any]:
    xs, values = zip(*points, strict=True)
    return _chart(title, x, y, xs, {y: values}) | {"points": True}


def _chart(
    title: str, x: str, y: str, xs: Sequence[float], lines: Mapping[str, Sequence[float]]
) -> dict[str, Any]:
    told = [{"label": label, "values": values} for label, values in lines.items()]
    return {"title": title, "x": x, "y": y, "xs": xs, "lines": told}


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
        "failed": summary.n_failures,
        "semantics": summary.semantics,
        "digest": summary.digest,
    }.items()
    yield from ((f"version of {name}", text) for name, text in manifest.versions.items())
    yield from ((f"setting {name}", text) for name, text in settings_table(summary.settings).rows)
    yield from ((f"SHA-256 of {name}", text) for name, text in islice(manifest.sha256.items(), 100))
