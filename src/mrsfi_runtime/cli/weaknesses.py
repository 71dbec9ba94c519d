"""The command ``mrsfi weaknesses``: which faults break which goal, as a matrix and as a list."""

from collections.abc import Iterable, Iterator, Sequence
from itertools import groupby
from pathlib import Path

import click
from rich.table import Table

from mrsfi.campaign_folders import OpenCampaign, open_campaign, open_to_fly
from mrsfi.engines import opened
from mrsfi.weaknesses import (
    FAULT_TREES,
    FMEA,
    format_of,
    known_by,
    write_fault_trees,
    write_fmea,
    write_forms,
)
from mrsfi_runtime.causes.counts import Column
from mrsfi_runtime.causes.weakness import MEASURES, Known, Weakness, in_seeds
from mrsfi_runtime.cli.console import counted, print_json, tell
from mrsfi_runtime.cli.engines import EngineOptions, WorkerOptions
from mrsfi_runtime.cli.tables import plain_table
from mrsfi_runtime.cli.terminal import print_table
from mrsfi_runtime.engine.settings import AUTO
from mrsfi_runtime.errors import UsageError, expected
from mrsfi_runtime.model.faults import FaultPool
from mrsfi_runtime.model.mission import Mission
from mrsfi_runtime.record.measure import NONE
from mrsfi_runtime.record.named_faults import NamedFault, named_faults
from mrsfi_runtime.record.settings import following


def weaknesses(
    run: Path,
    goal: str | None,
    n_seeds: int | None,
    *,
    engine: EngineOptions,
    workers: WorkerOptions,
    is_bounds: bool,
    is_json: bool,
    **files: Path | None,
) -> None:
    """Print the weaknesses of a campaign, of one goal or all."""
    if is_bounds and not is_json:
        raise click.UsageError("--bounds needs --json; without, they stand below the weaknesses")
    with open_campaign(run) as campaign:
        mission, pool = campaign.mission, campaign.pool
        if goal is not None and goal not in mission.goal_ids:
            raise UsageError(f"--goal: found '{goal}'; {expected(goal, mission.goal_ids)}")
        known = known_by(campaign)
        found = [each for each in known.weaknesses() if goal in {None, each.column.goal}]
        n_evaluations = campaign.store.n_evaluations
        _write(campaign, found, engine, **files)
    told = mission.goal_ids if goal is None else (goal,)
    if is_bounds:
        print_json(
            [
                {
                    "goal": column.goal,
                    "measure": column.kind,
                    "draws": n_kept,
                    "bound": known.bound(column),
                }
                for column, n_kept in known.n_kept.items()
                if column.goal in told
            ]
        )
        return
    if n_seeds is not None:
        found = _in_seeds(run, found, n_seeds, engine, workers)
    if is_json:
        print_json([each.as_json() for each in found])
        return
    broken = {each.column.goal for each in found}
    n_alone = len({each.column.goal for each in found if len(each.faults) == 1})
    click.echo(
        f"{len(broken)} of {counted(len(told), 'goals')} can be broken, {n_alone} of them by a "
        f"single fault, in {counted(n_evaluations, 'flights')} of one mission seed\n"
    )
    if found:
        print_table(
            "Share of the forms tried that break a goal; (…): only believed, *: unseen by the CI",
            *_matrices(mission, pool, told, found),
        )
        print_table(
            "How, in the form at work for the fewest ticks that were tried",
            *_lists(mission, pool, found),
        )
    print_table(
        "At most so many random specifications without any of these break it, too (95 % sure)",
        plain_table(("goal",), MEASURES, _bounds(known, told)),
    )


def _bounds(known: Known, goals: Sequence[str]) -> Iterator[tuple[str, ...]]:
    """Yield a row for each goal: the bound by each measure, after how many draws."""
    for goal in goals:
        columns = [Column(goal, measure) for measure in MEASURES]
        yield (
            goal,
            *(f"{100 * known.bound(each):.1f}% (0 of {known.n_kept[each]})" for each in columns),
        )


def _in_seeds(
    run: Path, found: list[Weakness], n_seeds: int, engine: EngineOptions, workers: WorkerOptions
) -> list[Weakness]:
    """Return weaknesses with the number of mission seeds in which they hold."""
    with open_to_fly(run, tell) as campaign:
        recorded = campaign.store.manifest.engine
        settings = engine.settings(recorded if recorded.is_foreign else None, AUTO)
        workers.require_sense(settings)
        seeds = following(campaign.store.settings.mission_seed, n_seeds)
        settings = workers.tried(campaign.code, seeds[0], settings)
        with workers.evaluator(campaign.code, seeds[0], settings) as evaluator:
            return [*in_seeds(campaign.mission, found, evaluator.evaluate_many, seeds)]


def _matrices(
    mission: Mission, pool: FaultPool, goals: Sequence[str], found: Iterable[Weakness]
) -> tuple[Table, Table]:
    """Return a row for each fault that breaks a goal, with what it touches, and without.

    A cell has the share of forms that break the goal alone, by the last measure that does; or says
    that it does so jointly with others.
    """
    cells: dict[str, dict[str, str]] = {}
    names: dict[str, NamedFault] = {}
    for weakness in sorted(found, key=lambda each: MEASURES.index(each.column.kind)):
        goal, kind = weakness.column
        share = _share(weakness)
        share = f"({share})" if kind == "believed" else f"{share}{'*' * weakness.is_masked}"
        for named in named_faults(mission, pool, weakness.witness):
            names[named.name] = named
            row = cells.setdefault(named.name, {})
            if len(weakness.faults) == 1:
                row[goal] = share
            else:
                row.setdefault(goal, "joint")
    rows = [
        (each.id, each.type, *(cells[each.id].get(goal, NONE) for goal in goals))
        for each in pool
        if each.id in cells
    ]
    told = ((*row, names[row[0]].target) for row in rows)
    wide = plain_table(("fault", "type"), goals, told, ("target",))
    narrow = plain_table(("fault", "type"), goals, rows)
    for table in (wide, narrow):
        table.padding = (0, 1, 0, 0)
        for column in table.columns:
            column.no_wrap = True
    return wide, narrow


def _lists(mission: Mission, pool: FaultPool, found: Iterable[Weakness]) -> Iterator[Table]:
    """Yield a table with a row for each fault of each weakness, and a narrow one.

    One set of faults that breaks a goal by several measures is one entry, with the form that breaks
    it by the last of them.
    """
    rows = []
    order = {goal: place for place, goal in enumerate(mission.goal_ids)}
    by_set = sorted(
        found, key=lambda each: (order[each.column.goal], len(each.faults), each.faults)
    )
    for (goal, _), each in groupby(by_set, key=lambda each: (each.column.goal, each.faults)):
        alike = {weakness.column.kind: weakness for weakness in each}
        shares = [_share(alike[kind]) if kind in alike else NONE for kind in MEASURES]
        shown = next(alike[kind] for kind in reversed(MEASURES) if kind in alike)
        shares += [f"{shown.n_held}/{shown.n_seeds}"]
        for place, named in enumerate(named_faults(mission, pool, shown.witness)):
            first = (goal, *shares) if place == 0 else ("", "and", "", "", "")
            window = f"{named.timed.start} … {named.timed.finish}"
            told = (named.name, named.fault.type, window, named.target, named.values)
            rows.append((*first, *told))
    columns = ("fault", "type", "window", "target", "values")
    wide = plain_table(("goal",), (*MEASURES, "seeds"), rows, columns)
    for column in wide.columns:
        column.no_wrap = True
    stacked = (
        (*row[:6], f"{row[6]}\n{row[7]}: {'; '.join(filter(None, row[8:]))}") for row in rows
    )
    narrow = plain_table(("goal",), (*MEASURES, "seeds"), stacked, ("fault", "how"))
    narrow.columns[-2].no_wrap = True
    for table in (wide, narrow):
        table.padding = (0, 1, 0, 0)
        yield table


def _share(weakness: Weakness) -> str:
    return f"{100 * weakness.share:.0f}%"


def _write(
    campaign: OpenCampaign,
    found: list[Weakness],
    engine: EngineOptions,
    xmi: Path | None,
    fmea: Path | None,
    fault_tree: Path | None,
) -> None:
    """Write the files that are wanted of weaknesses, and tell of each."""
    for path, known in ((fmea, FMEA), (fault_tree, FAULT_TREES)):
        if path is not None:
            format_of(path, known)
    if fmea is not None:
        with open_to_fly(campaign.folder.path, tell) as flown:
            recorded = flown.store.manifest.engine
            settings = engine.settings(recorded if recorded.is_foreign else None, AUTO)
            seed = flown.store.settings.mission_seed
            settings = settings.tried(flown.code, seed, tell, waits=False)
            with opened(flown.code, seed, settings, tell) as flown_by:
                write_fmea(flown, found, flown_by.record, fmea)
    if xmi is not None:
        write_forms(campaign, found, xmi)
    if fault_tree is not None:
        write_fault_trees(campaign, found, fault_tree)
    for path in filter(None, (xmi, fmea, fault_tree)):
        tell(f"written    {path}")
