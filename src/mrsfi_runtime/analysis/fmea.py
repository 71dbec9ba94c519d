"""Failure modes and effects: each least set of faults that breaks a goal, as a row of a table."""

import math
from collections.abc import Sequence
from functools import cache, lru_cache
from typing import NamedTuple

from mrsfi_runtime.analysis import table
from mrsfi_runtime.analysis.weaknesses import goal_in_words
from mrsfi_runtime.causes.chain import chains, local_effect
from mrsfi_runtime.causes.ways import Way
from mrsfi_runtime.causes.weakness import MEASURES
from mrsfi_runtime.engine.recording import Record
from mrsfi_runtime.model.faults import FaultPool, Specification
from mrsfi_runtime.model.mission import Mission
from mrsfi_runtime.record.measure import NONE
from mrsfi_runtime.record.named_faults import NamedFault, named_faults


class FailureMode(NamedTuple):
    """A row of the table, of the form that breaks the goal by the gravest measure.

    ``number`` is that of the way, ``form`` whether that is the mildest one, or the one that is
    listed, ``detected`` whether the collective intelligence believes that the goal is broken,
    ``ticks`` how long the goal is broken, by the measure that counts most, and ``occurrence`` the
    chance of all the faults, 0 … 1, as if none hung on another, if it is known.
    """

    number: int
    faults: str
    form: str
    item: str
    failure_mode: str
    local_effect: str
    end_effect: str
    measures: str
    detected: str
    severity: str
    ticks: int
    occurrence: float | None


def failure_modes(
    mission: Mission,
    pool: FaultPool,
    found: Sequence[Way],
    record: Record,
) -> list[FailureMode]:
    """Return what weaknesses come to, by occurrence where it is known, then by severity.

    Severest is what lets a goal be missed, then what breaks it for longest.
    """
    fly = lru_cache(4)(record)

    @cache
    def flown(form: Specification) -> tuple[str, list[int]]:
        effects = (local_effect(chain) or NONE for chain in chains(fly, mission, form))
        counts = (fly(form)[kind][-1].tolist() for kind in MEASURES)
        return "; ".join(effects), [*map(max, *counts)]

    def mode(way: Way) -> FailureMode:
        shown, place = way.at_least.shown, mission.goal_ids.index(way.goal)
        faults = named_faults(mission, pool, shown.witness)
        effect, ticks = flown(shown.witness)
        return FailureMode(
            number=way.number,
            faults=" ".join(way.faults),
            form="listed" if way.mildest is None else "mildest",
            item="; ".join(dict.fromkeys(each.target for each in faults)),
            failure_mode="; ".join(map(_mode, faults)),
            local_effect=effect,
            end_effect=goal_in_words(mission, way.goal),
            measures=", ".join(each.column.kind for each in way.by),
            detected="no" if shown.is_masked else "yes",
            severity="missed" if shown.column.kind == "missed" else "violated",
            ticks=ticks[place],
            occurrence=_chance([pool[fault].likelihood for fault in way.faults]),
        )

    return sorted(map(mode, found), key=_rank)


def _mode(named: NamedFault) -> str:
    window = f"{named.fault.type} from tick {named.timed.start} to {named.timed.finish}"
    return ", ".join(filter(None, (window, named.values)))


def _chance(chances: Sequence[float | None]) -> float | None:
    known = [chance for chance in chances if chance is not None]
    return math.prod(known) if len(known) == len(chances) else None


def _rank(mode: FailureMode) -> tuple[float, bool, int]:
    chance = 1.0 if mode.occurrence is None else -mode.occurrence
    return chance, mode.severity != "missed", -mode.ticks


def as_csv(_: str, modes: Sequence[FailureMode]) -> bytes:
    """Return failure modes as CSV."""
    return table.as_csv([FailureMode._fields, *modes])


def as_markdown(mission: str, modes: Sequence[FailureMode]) -> bytes:
    """Return failure modes of a mission, by its name, as a page in Markdown."""
    title = f"Failure modes of mission {mission}"
    modes_table = table.Table(
        title, [name.replace("_", " ") for name in FailureMode._fields], modes
    )
    return f"# {table.plain(title)}\n\n{table.to_markdown(modes_table)}\n".encode()
