"""The command ``mrsfi weaknesses``: which faults break which goal, as a matrix and as a list."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from mrsfi.engines import Given
from mrsfi_runtime.cli.console import print_json, tell
from mrsfi_runtime.cli.options import (
    FILE,
    engine_options,
    file_option,
    seeds_option,
    worker_options,
)
from mrsfi_runtime.errors import UsageError, expected
from mrsfi_runtime.record.engine_settings import AUTO, Workers

if TYPE_CHECKING:
    from collections.abc import Sequence

    from mrsfi.campaign_folders import OpenCampaign
    from mrsfi_runtime.causes.mildest import Way


@click.command(name="weaknesses")
@click.argument("run", metavar="RUN", type=click.Path(path_type=Path))
@click.option("--goal", metavar="G", help="Of this goal alone.")
@seeds_option("Fly in N mission seeds.")
@click.option("--mildest", "is_mildest", is_flag=True, help="Find the least that does it.")
@click.option(
    "--map",
    "drawn",
    type=(int, FILE),
    metavar="N FILE",
    help="Draw which values and windows of number N do: .csv, .png, .svg.",
)
@file_option("--fmea", "Write failure modes: .csv or .md.")
@file_option("--fault-tree", "Write .xml, or .txt for pfta.")
@worker_options
@engine_options(default=AUTO)
@click.option("--bounds", "is_bounds", is_flag=True, help="With --json: what was not found.")
@click.option("--json", "is_json", is_flag=True, help="Print them for a script.")
def command(
    run: Path,
    goal: str | None,
    n_seeds: int | None,
    engine: Given,
    workers: Workers,
    is_bounds: bool,
    is_mildest: bool,
    is_json: bool,
    **files: Any,
) -> None:
    """Print all the ways in which goals break, as a campaign found them.

    A weakness is a goal and a least set of faults that breaks it: in what the collective
    intelligence believes, in truth, or so that the goal is missed in the end. Shares say of how
    many forms that were tried, of other values and windows, as many did; one of them is shown. A
    goal that is broken already without faults is broken by those that make it worse by 5 % of the
    mission's ticks. A set holds in a mission seed if the form shown breaks the goal there, and no
    part of it does; five were looked at, or with --seeds as many as it says. Since is the tick at
    which the form shown first breaks it.

    With --mildest, of each set the form is sought, in some 30 flights, that is nearest to what is
    true and at work for the fewest ticks, and still breaks the goal in three mission seeds. --fmea
    tells that form where it is known, of all sets with --mildest, or else the one shown.

    Every campaign looks for them at its end; with --algorithm cover it does nothing else. One that
    was not let to does so with: mrsfi explain RUN --all

    \b
    Examples:
      mrsfi weaknesses runs/cover
      mrsfi weaknesses runs/cover --goal g2
      mrsfi weaknesses runs/cover --seeds 5
      mrsfi weaknesses runs/cover --goal g2 --mildest
      mrsfi weaknesses runs/cover --map 3 runs/map.png
      mrsfi weaknesses runs/cover --fmea runs/fmea.csv --fault-tree runs/trees.xml
      mrsfi weaknesses runs/cover --bounds --json
      mrsfi weaknesses runs/cover --json | jq '.[] | select(.detection.n_never > 0)'
    """
    from mrsfi.campaign_folders import open_campaign
    from mrsfi.explaining import flying_again, harvested, refined
    from mrsfi_runtime.cli import ways

    if is_bounds and not is_json:
        raise click.UsageError("--bounds needs --json; without, they stand below the weaknesses")
    with open_campaign(run) as campaign:
        goals = campaign.mission.goal_ids
        if goal is not None:
            if goal not in goals:
                raise UsageError(f"--goal: found '{goal}'; {expected(goal, goals)}")
            goals = (goal,)
        known = harvested(campaign)
        found = [way for way in known.ways if way.goal in goals]
        is_told = not is_bounds or any(files.values())
        is_named = bool(engine)  # whoever is named has to be the one that flew it
        if is_told and (is_mildest or n_seeds is not None or is_named):
            with flying_again(run, engine, workers, tell) as (flown, evaluator, own):
                found = refined(flown, evaluator, own.record, found, n_seeds, is_mildest=is_mildest)
        _write(campaign, found, engine, workers, **files)
        if is_bounds:
            ways.print_bounds(known.known, goals)
        elif is_mildest:
            ways.print_mildest(campaign, found, is_json=is_json)
        elif is_json:
            print_json([each for way in found for each in way.as_json()])
        else:
            ways.print_all(campaign, known.with_seeds_of(found), found, goals)


def _write(
    campaign: "OpenCampaign",
    found: "Sequence[Way]",
    engine: Given,
    workers: Workers,
    drawn: tuple[int, Path] | None = None,
    fmea: Path | None = None,
    fault_tree: Path | None = None,
) -> None:
    from mrsfi import explaining as of

    number, map_path = drawn or (0, None)
    files = ((fmea, of.FMEA), (fault_tree, of.FAULT_TREES), (map_path, of.MAPS))
    wanted = [(path, known) for path, known in files if path is not None]
    for path, known in wanted:
        of.require_format(path, known)
    drawn_of = None if drawn is None else of.way_of(campaign.folder.path, found, number)
    if fault_tree is not None:
        of.write_fault_trees(campaign, found, fault_tree)
    if fmea is not None or map_path is not None:
        run = campaign.folder.path
        with of.flying_again(run, engine, workers, tell) as (flown, evaluator, own):
            if fmea is not None:
                of.write_fmea(flown, found, own.record, fmea)
            if drawn_of is not None and map_path is not None:
                of.write_map(flown, evaluator, own.record, drawn_of, map_path)
    for path, _ in wanted:
        tell(f"written    {path}")
