"""What breaks which goal at the least, as people and scripts read of it."""

import math
from collections.abc import Iterable, Sequence
from functools import cache, lru_cache
from typing import NamedTuple

from mrsfi_runtime.analysis.table import Cell, Table, as_csv, plain, to_markdown
from mrsfi_runtime.causes.cause_set import Column
from mrsfi_runtime.causes.chain import chains, local_effect
from mrsfi_runtime.causes.mildest import Way
from mrsfi_runtime.causes.weakness import MEASURES, Known
from mrsfi_runtime.engine.recording import Record
from mrsfi_runtime.errors import counted
from mrsfi_runtime.model.fault_types import Units
from mrsfi_runtime.model.faults import FaultPool, Specification
from mrsfi_runtime.model.mission import Mission
from mrsfi_runtime.record.observers import NamedFault, named_faults
from mrsfi_runtime.record.store import NONE

_BREAKS = {"believed": "in what is believed", "true": "in truth", "missed": "for good"}


def matrix_table(mission: Mission, pool: FaultPool, found: Sequence[Way]) -> Table:
    """Return a row for each fault that breaks a goal: the fault, its type, goals, what it touches.

    A cell has the share of forms that break the goal alone, by the gravest measure; or says that
    the fault does so jointly with others. Goals that nothing breaks are left out.
    """
    cells: dict[str, dict[str, str]] = {}
    targets: dict[str, str] = {}
    for way in found:
        for named in named_faults(mission, pool, way.shown.witness):
            targets[named.name] = named.target
            row = cells.setdefault(named.name, {})
            if len(way.faults) == 1:
                share = f"{100 * way.shown.share:.0f}%"
                is_believed = way.shown.column.kind == MEASURES[0]
                row[way.goal] = f"({share})" if is_believed else share + "*" * way.is_undetected
            else:
                row.setdefault(way.goal, "joint")
    goals = [goal for goal in mission.goal_ids if any(way.goal == goal for way in found)]
    rows = [
        (fault.id, fault.type, *map(cells[fault.id].get, goals), targets[fault.id])
        for fault in pool
        if fault.id in cells
    ]
    title = "Share of forms that do; (%): only believed, *: undetected in some, joint: with others"
    columns = ("fault", "type", *goals, "target")
    words, folded = (*columns[:2], columns[-1]), ("goals", goals)
    return Table(title, columns, rows, words, is_compact=True, spare=words[-1:], folded=folded)


def harmless(pool: FaultPool, found: Iterable[Way]) -> str:
    """Return in a sentence which faults of a pool are in none of all ways to break a goal."""
    guilty = {fault for way in found for fault in way.faults}
    rest = [fault.id for fault in pool if fault.id not in guilty]
    faults = counted(len(pool), "faults")
    if not rest:
        return f"Each of {faults} breaks a goal in some form, alone or together with others"
    breaks = "breaks" if len(rest) == 1 else "break"
    return (
        f"{len(rest)} of {faults} {breaks} no goal in any form tried, alone or together: "
        f"{', '.join(rest)}"
    )


def way_table(title: str, mission: Mission, pool: FaultPool, found: Iterable[Way]) -> Table:
    """Return a row for each fault of each way, in the form that breaks the goal."""
    rows = []
    for way in found:
        shares = {each.column.kind: f"{100 * each.share:.0f}%" for each in way.by}
        shares[way.shown.column.kind] += "*" * way.is_undetected
        seeds = f"{way.shown.n_held}/{way.shown.n_seeds}"
        by = map(shares.get, MEASURES)
        head: tuple[Cell, ...] = (way.number, way.goal, *by, way.shown.since, seeds)
        for named in named_faults(mission, pool, way.shown.witness):
            window = f"{named.timed.start} … {named.timed.finish}"
            how = named.fault.type, window, named.target, named.told
            rows.append((*head, named.name, *how))
            head = ("", "and", *[""] * (len(head) - 2))
    folded = ("type", "window", "target", "values")
    columns = ("#", "goal", *MEASURES, "since", "seeds", "fault", *folded)
    words, texts = ("#", "goal", "fault", *folded[::2]), folded[1::2]
    return Table(title, columns, rows, words, texts, is_compact=True, folded=("how", folded))


def not_found(known: Known, goal: str) -> str:
    """Return in a sentence how seldom a goal may break in a way that is not known."""
    columns = {Column(goal, measure): words for measure, words in _BREAKS.items()}
    parts = (
        f"{100 * known.bound(column):.1f} % {words} (0 of {known.n_kept[column]})"
        for column, words in columns.items()
    )
    return (
        f"{goal} breaks under at most so many random specifications without these: "
        f"{', '.join(parts)}; 95 % sure"
    )


def goal_in_words(mission: Mission, goal: str) -> str:
    """Return the name of a goal, if it has one, before its ID."""
    name = mission.goals[mission.goal_ids.index(goal)].name
    return f"{name} ({goal})" if name else goal


def detection(way: Way, units: Units) -> str:
    """Return whether the CI detects what breaks a goal."""
    if way.shown.column.kind == MEASURES[0]:
        return "a false alarm of the CI"
    return way.shown.detection.in_words(units) if way.shown.detection else "detection not recorded"


def verdict(way: Way, units: Units) -> str:
    """Return in words how firmly a way breaks its goal, and whether the CI detects it."""
    shown = way.shown
    kind = shown.column.kind
    alone = "alone" if len(way.faults) == 1 else "together"
    how = f"only {_BREAKS[kind]}" if kind == MEASURES[0] else _BREAKS[kind]
    seen = "" if kind == MEASURES[0] else f", {detection(way, units)}"
    return (
        f"{' and '.join(way.faults)} {alone}, {how}{seen}; "
        f"{100 * shown.share:.0f} % of {counted(shown.n_tried, 'forms')} "
        f"{'does' if shown.n_tried == 1 else 'do'}, "
        f"this one in {shown.n_held} of {shown.n_seeds} mission seeds"
    )


def broken_by(way: Way, units: Units) -> str:
    """Return in sentences by what a goal is broken, and from what on if that is known."""
    least = f" {way.mildest.sentence}." if way.mildest else ""
    return f"Broken by {verdict(way, units)}.{least}"


class FailureMode(NamedTuple):
    """A row of the table, of the form that breaks the goal by the gravest measure.

    ``number`` is that of the way, ``form`` whether that is the mildest one, or the one that is
    listed; ``measures`` and ``ticks`` say for how long the goal is broken by this form, by each
    measure and by the one that counts most, and ``detected`` how many variants are. ``occurrence``
    is the chance of all the faults, 0 … 1, as if none hung on another, if it is known.
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
    fly, units = lru_cache(4)(record), mission.units

    @cache
    def flown(form: Specification) -> tuple[str, list[tuple[int, ...]]]:
        effects = (local_effect(chain, units) or NONE for chain in chains(fly, mission, form))
        counts = (fly(form)[kind][-1].tolist() for kind in MEASURES)
        return "; ".join(effects), [*zip(*counts, strict=True)]

    def mode(way: Way) -> FailureMode:
        shown, place = way.at_least.shown, mission.goal_ids.index(way.goal)
        faults = named_faults(mission, pool, shown.witness)
        effect, counts = flown(shown.witness)
        return FailureMode(
            number=way.number,
            faults=" ".join(way.faults),
            form="listed" if way.mildest is None else "mildest",
            item="; ".join(dict.fromkeys(each.target for each in faults)),
            failure_mode="; ".join(map(_mode, faults)),
            local_effect=effect,
            end_effect=goal_in_words(mission, way.goal),
            measures=", ".join(map("{} {}".format, MEASURES, counts[place])),
            detected=detection(way, units),
            severity="missed" if shown.column.kind == "missed" else "violated",
            ticks=max(counts[place]),
            occurrence=_chance([pool[fault].likelihood for fault in way.faults]),
        )

    return sorted(map(mode, found), key=_rank)


def _mode(named: NamedFault) -> str:
    window = f"{named.fault.type} from tick {named.timed.start} to {named.timed.finish}"
    return ", ".join(filter(None, (window, named.told)))


def _chance(chances: Sequence[float | None]) -> float | None:
    known = [chance for chance in chances if chance is not None]
    return math.prod(known) if len(known) == len(chances) else None


def _rank(mode: FailureMode) -> tuple[float, bool, int]:
    chance = 1.0 if mode.occurrence is None else -mode.occurrence
    return chance, mode.severity != "missed", -mode.ticks


def modes_as_csv(_: str, modes: Sequence[FailureMode]) -> bytes:
    """Return failure modes as CSV."""
    return as_csv([FailureMode._fields, *modes])


def modes_as_markdown(mission: str, modes: Sequence[FailureMode]) -> bytes:
    """Return failure modes of a mission, by its name, as a page in Markdown."""
    title = f"Failure modes of mission {mission}"
    modes_table = Table(title, [name.replace("_", " ") for name in FailureMode._fields], modes)
    return f"# {plain(title)}\n\n{to_markdown(modes_table)}\n".encode()
