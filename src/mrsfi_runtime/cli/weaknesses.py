"""The command ``mrsfi weaknesses``: which faults break which goal, as a matrix and as a list."""

import math
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from itertools import islice
from pathlib import Path
from time import monotonic
from typing import Any

import click
from rich.table import Table

from mrsfi.campaign_folders import FlyableCampaign, OpenCampaign, open_campaign, open_to_fly
from mrsfi.engines import own_engine
from mrsfi.weaknesses import (
    FAULT_TREES,
    FMEA,
    MAPS,
    harvest,
    harvested,
    mildest,
    require_format,
    untried,
    way_of,
    write_fault_trees,
    write_fmea,
    write_map,
)
from mrsfi_runtime.analysis.weaknesses import (
    LISTED,
    MATRIX,
    harmless,
    listed,
    matrix,
    not_found,
    said,
)
from mrsfi_runtime.causes.ways import Way
from mrsfi_runtime.causes.weakness import Known, Weakness, in_seeds
from mrsfi_runtime.cli.console import counted, print_json, tell
from mrsfi_runtime.cli.engines import EngineOptions, WorkerOptions
from mrsfi_runtime.cli.tables import plain_table
from mrsfi_runtime.cli.terminal import print_table
from mrsfi_runtime.engine.flights import Engine, Evaluator
from mrsfi_runtime.engine.settings import AUTO, EngineSettings
from mrsfi_runtime.errors import UsageError, expected
from mrsfi_runtime.model.faults import FaultPool
from mrsfi_runtime.model.mission import Mission
from mrsfi_runtime.record.folder import CampaignFolder, only_writer
from mrsfi_runtime.record.settings import following

_MOST_UNTRIED = 10
"""Faults and pairs that are named at most, of those that were never flown."""

_EVERY = 2.0
"""Seconds between two lines about a harvest."""


def weaknesses(
    run: Path,
    goal: str | None,
    n_seeds: int | None,
    *,
    engine: EngineOptions,
    workers: WorkerOptions,
    is_bounds: bool,
    is_mildest: bool = False,
    is_json: bool,
    **files: Any,
) -> None:
    """Print the weaknesses of a campaign, of one goal or all."""
    if is_bounds and not is_json:
        raise click.UsageError("--bounds needs --json; without, they stand below the weaknesses")
    with open_campaign(run) as campaign:
        mission, pool = campaign.mission, campaign.pool
        if goal is not None and goal not in mission.goal_ids:
            raise UsageError(f"--goal: found '{goal}'; {expected(goal, mission.goal_ids)}")
        known = harvested(campaign)
        found = [way for way in known.ways if goal in {None, way.goal}]
        never = "" if is_json else _never_flown(campaign)
        if is_mildest or n_seeds is not None:
            found = _flown(run, found, n_seeds, engine, workers, is_mildest=is_mildest)
        _write(campaign, found, engine, workers, **files)
    told = mission.goal_ids if goal is None else (goal,)
    if is_bounds:
        _print_bounds(known.known, told)
        return
    if is_mildest:
        _tell_mildest(mission, pool, found, is_json=is_json)
        return
    if is_json:
        print_json([each for way in found for each in way.as_json()])
        return
    click.echo(f"{said(told, found, known.n_flights)}\n")
    if found:
        print_ways(mission, pool, found)
        print_list(mission, pool, found, "How, in one of the forms that do")
    click.echo("\n".join(not_found(known.known, each) for each in told) + "\n")
    click.echo(f"{harmless(pool, known.ways)}\n{never}")


def _never_flown(campaign: OpenCampaign) -> str:
    """Return in a sentence which faults and pairs of faults no specification had."""
    n_faults, never = len(campaign.pool), untried(campaign)
    return (
        f"Of {n_faults} faults and {n_faults * (n_faults - 1) // 2} pairs, never flown: "
        f"{', '.join(' with '.join(each) for each in never[:_MOST_UNTRIED]) or 'none'}"
        f"{f' and {len(never) - _MOST_UNTRIED} more' if len(never) > _MOST_UNTRIED else ''}"
    )


def _print_bounds(known: Known, goals: Sequence[str]) -> None:
    """Print how seldom some goals may break in a way that is not known, for a script."""
    print_json(
        [
            {
                "goal": column.goal,
                "measure": column.kind,
                "draws": n_kept,
                "bound": known.bound(column),
            }
            for column, n_kept in known.n_kept.items()
            if column.goal in goals
        ]
    )


def harvest_now(run: Path, engine: EngineOptions, workers: WorkerOptions, *, is_json: bool) -> None:
    """Find what a campaign does not know yet of the ways in which goals break; print them."""
    with (
        only_writer(CampaignFolder(run)),
        open_to_fly(run, tell) as campaign,
        _evaluator(campaign, engine, workers) as (evaluator, settings),
    ):
        show_harvest(campaign, evaluator, settings)
    weaknesses(run, None, None, engine=engine, workers=workers, is_bounds=False, is_json=is_json)


def show_harvest(campaign: FlyableCampaign, evaluator: Evaluator, settings: EngineSettings) -> bool:
    """Find all the ways in which goals break, and tell; return whether anything was flown."""
    n_before = len(campaign.store.flights())
    told = -math.inf

    def tell_of(known: Known, n_flown: int, n_most: int) -> None:
        nonlocal told
        if n_flown > n_before and monotonic() - told > _EVERY:
            told = monotonic()
            tell(f"harvest  {n_flown} of at most {n_most} flights  {_found(known.weaknesses())}")

    found = harvest(campaign, evaluator, settings, tell_of)
    is_new = len(campaign.store.flights()) > n_before
    if is_new:
        tell(f"harvest  {counted(found.n_flights, 'flights')}  {_found(found.weaknesses)}")
    return is_new


def _found(weaknesses: Iterable[Weakness]) -> str:
    found = {(each.column.goal, each.faults) for each in weaknesses}
    goals = {goal for goal, _ in found}
    return f"{counted(len(found), 'ways')} to break {counted(len(goals), 'goals')}"


def _flown(
    run: Path,
    found: Sequence[Way],
    n_seeds: int | None,
    engine: EngineOptions,
    workers: WorkerOptions,
    *,
    is_mildest: bool,
) -> list[Way]:
    """Return ways, each with its mildest form if asked for, in as many mission seeds as asked."""
    with _flying(run, engine, workers) as (campaign, evaluator, own):
        least = mildest(campaign, evaluator, own.record, found) if is_mildest else ()
        told = [one.weakness for one in least] or [one for way in found for one in way.by]
        if n_seeds is not None:
            seeds = following(campaign.store.settings.mission_seed, n_seeds)
            told = [*in_seeds(campaign.mission, told, evaluator.evaluate_many, seeds)]
    flown = iter(told)
    if is_mildest:
        forms = (replace(each, weakness=next(flown)) for each in least)
        return [replace(way, mildest=form) for way, form in zip(found, forms, strict=True)]
    return [replace(way, by=tuple(islice(flown, len(way.by)))) for way in found]


def _tell_mildest(
    mission: Mission, pool: FaultPool, found: Sequence[Way], *, is_json: bool
) -> None:
    """Print the mildest form of each of some ways to break a goal."""
    told = [(way, way.mildest) for way in found if way.mildest is not None]
    if is_json:
        print_json([{"number": way.number, **each.as_json()} for way, each in told])
        return
    shown = [replace(way, by=(each.weakness,)) for way, each in told]
    print_list(mission, pool, shown, "The mildest form that was found")
    for way, each in told:
        click.echo(f"{way.number}  {each.sentence} ({counted(each.n_flights, 'flights')})")


@contextmanager
def _flying(
    run: Path, engine: EngineOptions, workers: WorkerOptions
) -> Iterator[tuple[FlyableCampaign, Evaluator, Engine]]:
    """Yield a campaign, what evaluates specifications of it, and what records one."""
    with (
        open_to_fly(run, tell) as campaign,
        _evaluator(campaign, engine, workers) as (evaluator, settings),
    ):
        seed = campaign.store.settings.mission_seed
        with own_engine(evaluator, campaign.code, seed, settings) as own:
            yield campaign, evaluator, own


@contextmanager
def _evaluator(
    campaign: FlyableCampaign, engine: EngineOptions, workers: WorkerOptions
) -> Iterator[tuple[Evaluator, EngineSettings]]:
    """Yield what flies specifications of a campaign, and on what."""
    recorded = campaign.store.manifest.engine
    settings = engine.settings(recorded if recorded.is_foreign else None, AUTO)
    workers.require_sense(settings)
    seed = campaign.store.settings.mission_seed
    settings = settings.tried(campaign.code, seed, tell)
    with workers.evaluator(campaign.code, seed, settings) as evaluator:
        yield evaluator, settings


def print_ways(mission: Mission, pool: FaultPool, found: Sequence[Way]) -> None:
    """Print which fault breaks which goal, of those goals that some do."""
    goals = [goal for goal in mission.goal_ids if any(way.goal == goal for way in found)]
    rows = [*matrix(mission, pool, goals, found)]
    wide = plain_table(("fault", "type"), goals, rows, ("target",))
    narrow = plain_table(("fault", "type"), goals, (row[:-1] for row in rows))
    print_table(MATRIX, *_compact(wide, narrow))


def print_list(mission: Mission, pool: FaultPool, found: Sequence[Way], title: str) -> None:
    """Print ways to break goals, with a row for each fault of each."""
    n_first = LISTED.index("fault")
    rows = [*listed(mission, pool, found)]
    numbers, told = LISTED[1:n_first], LISTED[n_first:]
    wide = plain_table(("#", LISTED[0]), numbers, rows, told)
    stacked = (
        (*row[: n_first + 2], f"{row[n_first + 2]}\n{row[-3]}: {'; '.join(filter(None, row[-2:]))}")
        for row in rows
    )
    narrow = plain_table(("#", LISTED[0]), numbers, stacked, ("fault", "how"))
    wide.columns[-1].no_wrap = True
    narrow.columns[-2].no_wrap = True
    print_table(title, *_compact(wide, narrow, n_first + 1))


def _compact(wide: Table, narrow: Table, n_whole: int | None = None) -> tuple[Table, Table]:
    """Return tables with little room between columns, the first of which are not wrapped."""
    for table in (wide, narrow):
        table.padding = (0, 1, 0, 0)
    for column in (*wide.columns, *narrow.columns[:n_whole]):
        column.no_wrap = True
    return wide, narrow


def _write(
    campaign: OpenCampaign,
    found: Sequence[Way],
    engine: EngineOptions,
    workers: WorkerOptions,
    drawn: tuple[int, Path] | None = None,
    fmea: Path | None = None,
    fault_tree: Path | None = None,
) -> None:
    """Write the files that are wanted of weaknesses, and tell of each."""
    number, map_path = drawn or (0, None)
    files = {fmea: FMEA, fault_tree: FAULT_TREES, map_path: MAPS}
    wanted = [path for path in files if path is not None]
    for path in wanted:
        require_format(path, files[path])
    drawn_of = None if drawn is None else way_of(campaign.folder.path, found, number)
    if fault_tree is not None:
        write_fault_trees(campaign, found, fault_tree)
    if fmea is not None or map_path is not None:
        with _flying(campaign.folder.path, engine, workers) as (flown, evaluator, own):
            if fmea is not None:
                write_fmea(flown, found, own.record, fmea)
            if drawn_of is not None and map_path is not None:
                write_map(flown, evaluator, own.record, drawn_of, map_path)
    for path in wanted:
        tell(f"written    {path}")
