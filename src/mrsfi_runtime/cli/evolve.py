"""The command ``mrsfi evolve``: begins a campaign or continues one, by one writer at a time."""

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
from click.core import ParameterSource

from mrsfi.engines import Given, chosen
from mrsfi_runtime.cli.console import tell
from mrsfi_runtime.cli.options import (
    OF_ENGINE,
    engine_options,
    folder_option,
    generated_option,
    worker_options,
)
from mrsfi_runtime.errors import TransportError, UsageError, WorkerLost
from mrsfi_runtime.model.faults import COSTS
from mrsfi_runtime.record.engine_settings import AUTO, EngineSettings, Workers
from mrsfi_runtime.record.settings import ALGORITHM_NAMES, MINIMISING, VIOLATIONS

if TYPE_CHECKING:
    from contextlib import AbstractContextManager

    from mrsfi.campaign_folders import FlyableCampaign

_FREE = {"resume", "ratio", "explain", "is_json"} | OF_ENGINE
"""Parameters of ``mrsfi evolve`` that do not decide what a campaign finds."""


def _goal_ids(_: click.Context, __: click.Parameter, text: str | None) -> list[str] | None:
    return None if text is None else [goal.strip() for goal in text.split(",")]


@click.command(name="evolve")
@click.pass_context
@click.argument("mission", metavar="[MISSION]", required=False)
@generated_option
@click.option(
    "--case",
    show_default="a",
    metavar="a|b|FILE",
    help="Campaign file: case_NAME.toml beside the models, or any TOML file.",
)
@click.option("--seed", type=int, help="Seed of the search.")
@click.option("--mission-seed", type=int, help="Mission seed: decides the samples.")
@click.option(
    "--algorithm",
    metavar="NAME",
    help=f"How to search: {', '.join(ALGORITHM_NAMES)}, or your own, MODULE:FUNCTION.",
)
@click.option("--generations", type=int, help="Generations after the first.")
@click.option("--population", type=int, help="Individuals of a generation.")
@click.option("--evaluations", type=int, help="Stop after exactly so many evaluations.")
@click.option("--until", type=float, metavar="P", help="Cover until all bounds are at most P.")
@click.option("--faults", type=int, help="Timed faults of an individual; with --minimise at most.")
@click.option("--goals", metavar="G,H,…", callback=_goal_ids, help="Goals to look at.")
@click.option("--violations", metavar="NAME", help=f"What is counted: {', '.join(VIOLATIONS)}.")
@click.option(
    "--minimise",
    metavar="|".join(COSTS),
    help=f"Also seek few of these, by algorithm {' or '.join(MINIMISING)}.",
)
@worker_options
@engine_options(default=AUTO)
@folder_option("--out", "New folder of the campaign [default: runs/NAME-CASE-N, first free N].")
@click.option(
    "--resume",
    type=click.Path(path_type=Path),
    metavar="DIR",
    help="Go on with the campaign in DIR, with its own settings; no MISSION then.",
)
@click.option("--ratio", metavar="G:H=M:N", help="Also pick from the front, such as g3:g1=2:1.")
@click.option(
    "--explain/--no-explain",
    default=None,
    help="Look for weaknesses after the search, or not: then there are no weaknesses, no mildest "
    "variants, and nothing of them in report and page, for show and for keep [default: --explain, "
    "or as the campaign was begun].",
)
@click.option("--json", "is_json", is_flag=True, help="Print the summary for a script.")
def command(
    ctx: click.Context,
    /,
    engine: Given,
    workers: Workers,
    resume: Path | None,
    ratio: str | None,
    explain: bool | None,
    is_json: bool,
    **given: Any,
) -> None:
    """Evolve fault specifications against MISSION and print what breaks it.

    The campaign file says how: algorithm, population, generations, fitness. --case a and
    --case b are the files case_a.toml and case_b.toml beside the models; options replace single
    values. Everything goes into a new folder, runs/NAME-CASE-N: copies of the models and of the
    code it ran on, every evaluation, figures, tables, and the ten worst as XMI.

    Then it finds out which faults break which goal, and what is the least that does, with at most
    as many flights as the search took, and never more than a thousand; what it prints first is
    that. mrsfi weaknesses lists all of it; mrsfi explain says why one specification does what it
    does. Somebody else's simulation is only searched on.

    \b
    Examples:
      mrsfi evolve uuv_sampling
      mrsfi evolve uuv_sampling --case b --ratio g3:g1=2:1
      mrsfi evolve uuv_sampling --seed 7 --generations 5 --out runs/short
      mrsfi evolve uuv_sampling --algorithm random --evaluations 1000
      mrsfi evolve uuv_sampling --algorithm cover --until 0.02
      mrsfi evolve uuv_sampling --algorithm guided --minimise faults --violations true --goals g2
      mrsfi evolve uuv_sampling --case my_campaign.toml --json | jq .best.fitness
      mrsfi evolve --resume runs/uuv_sampling-a-1

    Same seed, same result, bit for bit, with any number of workers. A campaign that was ended,
    by Ctrl-C, a kill or a loss of power, can be reported and replayed, and goes on with
    --resume DIR: nothing that is recorded is evaluated again, and the result is that of one run.
    """
    from mrsfi.evolving import evolve
    from mrsfi_runtime.analysis.illustrations import DrawingProcess, map_drawing
    from mrsfi_runtime.cli.progress import search_progress
    from mrsfi_runtime.cli.summary import report

    if resume is None:
        opened = _begun(chosen(engine, AUTO), workers, ratio, **given)
    else:
        opened = _resumed(resume, ctx, engine, workers, ratio)
    with (
        opened as (campaign, flown_by),
        DrawingProcess(map_drawing(campaign.mission)) as process,
    ):
        path = campaign.folder.path
        watched = search_progress(campaign.store)
        try:
            evolve(campaign, flown_by, workers, watched, explains=explain, tell=tell)
        except (KeyboardInterrupt, TransportError, WorkerLost):
            if any(campaign.store.next_indexes()):
                tell(f"what was found until now is kept; see it with: mrsfi report {path}")
                tell(f"go on with: mrsfi evolve --resume {path}")
            raise
        report(campaign, ratio, is_json=is_json, draw=process.draw)


def _begun(
    engine: EngineSettings,
    workers: Workers,
    ratio: str | None,
    mission: str | None,
    generated: Path | None,
    case: str | None,
    out: Path | None,
    **overrides: object,
) -> "AbstractContextManager[tuple[FlyableCampaign, EngineSettings]]":
    from mrsfi.evolving import begun
    from mrsfi.folders import campaign_file, find_mission
    from mrsfi.loading import load_fresh
    from mrsfi_runtime.record.settings import CampaignSettings

    workers.require_sense(engine)
    if mission is None:
        raise UsageError("found no MISSION; expected one, or --resume DIR to go on with a campaign")
    case = case or "a"
    folders = find_mission(mission, generated)
    settings = CampaignSettings.load(campaign_file(folders, case), **overrides)
    code = load_fresh(folders)
    return begun(folders, code, settings, case, engine, out=out, ratio=ratio, tell=tell)


def _resumed(
    path: Path, ctx: click.Context, engine: Given, workers: Workers, ratio: str | None
) -> "AbstractContextManager[tuple[FlyableCampaign, EngineSettings]]":
    from mrsfi.evolving import resumed
    from mrsfi_runtime.record.store import CampaignStore

    with CampaignStore.open(path) as store:  # first: a lock makes no sense where no campaign is
        store.require_flyable()
        manifest, settings = store.manifest, store.settings
    begun_with = {"mission": manifest.mission, "case": manifest.case, **settings.as_json()}
    _require_same_options(path, ctx, begun_with)
    flown_by = chosen(engine, AUTO, manifest.engine)
    workers.require_sense(flown_by)
    return resumed(path, flown_by, ratio=ratio, tell=tell)


def _require_same_options(path: Path, ctx: click.Context, recorded: Mapping[str, Any]) -> None:
    for parameter in ctx.command.params:
        name = str(parameter.name)
        if name in _FREE or ctx.get_parameter_source(name) is not ParameterSource.COMMANDLINE:
            continue
        given = ctx.params[name]
        label = parameter.opts[0] if isinstance(parameter, click.Option) else "MISSION"
        if name not in recorded:
            raise UsageError(
                f"{label} {given}: makes no sense with --resume; {path} goes on in its own folder, "
                "on its own copies of models and code; leave it out"
            )
        found = Path(given).name if name == "mission" else given
        if found != recorded[name]:
            raise UsageError(
                f"{label}: found {given}; {path} was begun with {recorded[name]} and goes on with "
                "it; leave the option out, or begin a new campaign without --resume"
            )
