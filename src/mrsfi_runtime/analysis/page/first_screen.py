"""What the page shows first: a sentence a goal, which fault breaks which, and what to do next."""

import shlex
from collections.abc import Callable, Mapping, Sequence
from itertools import groupby
from typing import Any

from mrsfi_runtime.analysis.summary import Summary
from mrsfi_runtime.analysis.verdicts import (
    GoalVerdict,
    State,
    cause_in_words,
    noticed,
    owner_of,
    when_noticed,
)
from mrsfi_runtime.analysis.weaknesses import harmless, verdict
from mrsfi_runtime.causes.ways import Way, least
from mrsfi_runtime.errors import counted

_MARKS = dict(zip(State, "×!!?✓", strict=True))
"""What stands for the state of a goal."""


def first_screen(
    summary: Summary, next_of: Callable[[Way], Mapping[str, Sequence[str]]]
) -> dict[str, Any] | None:
    """Return what is shown of a campaign, if anybody looked; ``next_of`` has commands by aim."""
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
        "goals": [_goal(each) for each in summary.verdicts],
        "ways": [
            {
                "number": way.number,
                "goal": way.goal,
                "name": names[way.goal],
                "said": f"{names[way.goal]} breaks if {cause_in_words(mission, pool, way)}; "
                f"{noticed(way.shown)}",
                "sure": verdict(way),
                "kind": way.shown.column.kind,
                "unseen": way.is_unseen,
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
        "noticed": "" if way is None else when_noticed(way.shown),
        "sure": each.sure,
        "others": f"{counted(each.n_others, 'ways')} more" if each.n_others else "",
        "unknown": each.unknown,
        "number": None if way is None else way.number,
    }


def _matrix(summary: Summary) -> dict[str, Any]:
    """Return which fault breaks which goal: goals by faults, these by whom they strike."""
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
