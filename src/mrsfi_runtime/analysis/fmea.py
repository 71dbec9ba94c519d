"""Failure modes and effects: each least set of faults that breaks a goal, as a row of a table."""

import math
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import cache, lru_cache
from typing import NamedTuple, TypeAlias

from mrsfi_runtime.analysis import markdown, tables
from mrsfi_runtime.causes.chain import chains
from mrsfi_runtime.causes.sentence import local_effect
from mrsfi_runtime.causes.weakness import MEASURES, Weakness
from mrsfi_runtime.engine.recording import Recording
from mrsfi_runtime.model.faults import FaultPool, Specification
from mrsfi_runtime.model.mission import Mission
from mrsfi_runtime.record.measure import NONE
from mrsfi_runtime.record.named_faults import NamedFault, named_faults

Record: TypeAlias = Callable[[Specification], Recording]
"""Flies fault specifications, all in one mission seed, and returns every tick."""


def by_set(mission: Mission, found: Iterable[Weakness]) -> list[Mapping[str, Weakness]]:
    """Return weaknesses by measure, the gravest last, for each goal in model order and each set."""
    sets: dict[tuple[int, int, tuple[str, ...]], dict[str, Weakness]] = {}
    for each in sorted(found, key=lambda each: MEASURES.index(each.column.kind)):
        place = mission.goal_ids.index(each.column.goal), len(each.faults), each.faults
        sets.setdefault(place, {})[each.column.kind] = each
    return [sets[place] for place in sorted(sets)]


class Names:
    """Gives out names of ASCII letters, digits, ``_`` and ``-`` that differ in any case."""

    def __init__(self) -> None:
        self._taken: set[str] = set()

    def of(self, *words: str) -> str:
        """Return a name made of words, numbered if it is taken: ``g2-f9``, ``g2-f9-2``."""
        stem = "-".join(re.sub(r"\W", "_", word, flags=re.ASCII) for word in words)[:100]
        name, number = stem, 1
        while name.lower() in self._taken:
            number += 1
            name = f"{stem}-{number}"
        self._taken.add(name.lower())
        return name


def forms(mission: Mission, found: Iterable[Weakness]) -> dict[tuple[str, Specification], str]:
    """Return the name of each form by goal and form: ``g2-f9``, of goal and faults.

    It is ``g2-f9-believed`` where a graver measure has another form.
    """
    names = Names()
    known: dict[tuple[str, Specification], str] = {}
    for alike in by_set(mission, found):
        *_, gravest = alike
        for kind, each in [*alike.items()][::-1]:
            if (key := (each.column.goal, each.witness)) not in known:
                measure = () if kind == gravest else (kind,)
                known[key] = names.of(each.column.goal, *each.faults, *measure)
    return known


class FailureMode(NamedTuple):
    """A row of the table, of the form that breaks the goal by the gravest measure.

    ``detected`` is whether the collective intelligence believes the goal broken, ``form`` a name as
    in ``forms``, ``ticks`` how long the goal is broken, by the measure that counts most, and
    ``occurrence`` the chance of all the faults, 0 … 1, as if none hung on another, if it is known.
    """

    faults: str
    item: str
    failure_mode: str
    local_effect: str
    end_effect: str
    measures: str
    detected: str
    form: str
    severity: str
    ticks: int
    occurrence: float | None


def failure_modes(
    mission: Mission,
    pool: FaultPool,
    found: Sequence[Weakness],
    record: Record,
) -> list[FailureMode]:
    """Return what weaknesses come to, by occurrence where it is known, then by severity.

    Severest is what lets a goal be missed, then what breaks it for longest.
    """
    fly, names = lru_cache(4)(record), forms(mission, found)

    @cache
    def flown(form: Specification) -> tuple[str, list[int]]:
        effects = (local_effect(chain) or NONE for chain in chains(fly, mission, form))
        counts = (fly(form)[kind][-1].tolist() for kind in MEASURES)
        return "; ".join(effects), [*map(max, *counts)]

    def mode(alike: Mapping[str, Weakness]) -> FailureMode:
        *_, shown = alike.values()
        place = mission.goal_ids.index(shown.column.goal)
        goal, faults = mission.goals[place], named_faults(mission, pool, shown.witness)
        effect, ticks = flown(shown.witness)
        return FailureMode(
            faults=" ".join(shown.faults),
            item="; ".join(dict.fromkeys(each.target for each in faults)),
            failure_mode="; ".join(map(_mode, faults)),
            local_effect=effect,
            end_effect=f"{goal.name} ({goal.id})",
            measures=", ".join(alike),
            detected="no" if shown.is_masked else "yes",
            form=names[goal.id, shown.witness],
            severity="missed" if "missed" in alike else "violated",
            ticks=ticks[place],
            occurrence=_chance([pool[fault].likelihood for fault in shown.faults]),
        )

    return sorted(map(mode, by_set(mission, found)), key=_rank)


def _mode(named: NamedFault) -> str:
    window = f"{named.fault.type} from tick {named.timed.start} to {named.timed.finish}"
    return ", ".join(filter(None, (window, named.values)))


def _chance(chances: Sequence[float | None]) -> float | None:
    known = [chance for chance in chances if chance is not None]
    return math.prod(known) if len(known) == len(chances) else None


def _rank(mode: FailureMode) -> tuple[float, bool, int]:
    chance = 1.0 if mode.occurrence is None else -mode.occurrence
    return chance, mode.severity != "missed", -mode.ticks


def as_csv(_: Mission, modes: Sequence[FailureMode]) -> bytes:
    """Return failure modes as CSV."""
    return tables.as_csv([FailureMode._fields, *modes])


def as_markdown(mission: Mission, modes: Sequence[FailureMode]) -> bytes:
    """Return failure modes as a page in Markdown."""
    header = [name.replace("_", " ") for name in FailureMode._fields]
    rows = (
        (*mode[:-1], NONE if mode.occurrence is None else f"{mode.occurrence:g}") for mode in modes
    )
    title = f"# Failure modes of mission {markdown.plain(mission.name)}"
    return f"{title}\n\n{markdown.table(header, rows)}\n".encode()
