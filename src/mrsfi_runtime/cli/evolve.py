"""The command ``mrsfi evolve``."""

import os
from pathlib import Path

import click

from mrsfi_runtime.analysis.fronts import goal_columns, parse_ratio
from mrsfi_runtime.cli.campaigns import (
    OpenCampaign,
    free_folder,
    manifest,
    open_campaign,
)
from mrsfi_runtime.cli.console import tell
from mrsfi_runtime.cli.missions import (
    MissionFolders,
    find_mission,
    generated_option,
    mission_argument,
)
from mrsfi_runtime.cli.progress import search_progress
from mrsfi_runtime.cli.results import report
from mrsfi_runtime.engine.pools import WorkerPool
from mrsfi_runtime.errors import UsageError
from mrsfi_runtime.mission import load_code
from mrsfi_runtime.model.mission import Mission
from mrsfi_runtime.record.campaign import CampaignStore
from mrsfi_runtime.record.folder import CampaignFolder
from mrsfi_runtime.search.algorithms import ALGORITHMS
from mrsfi_runtime.search.campaign import require_settings, run_campaign
from mrsfi_runtime.search.settings import CampaignSettings

ENGINES = ("reference",)
"""Ways to evaluate a fault specification."""

_HELP = """Evolve fault specifications against MISSION and print the ten most critical.

The campaign file says how: algorithm, population, generations, fitness. --case a and
--case b are the files case_a.toml and case_b.toml beside the models; options replace single
values. Everything goes into a new folder, runs/NAME-CASE-N: copies of the models and of the
code it ran on, every evaluation, figures, tables, and the ten worst as XMI.

\b
Examples:
  mrsfi evolve uuv_sampling
  mrsfi evolve uuv_sampling --case b --ratio g3:g1=2:1
  mrsfi evolve uuv_sampling --seed 7 --generations 5 --out runs/short
  mrsfi evolve uuv_sampling --algorithm random --evaluations 1000
  mrsfi evolve uuv_sampling --case my_campaign.toml --json | jq .best.fitness

Same seed, same result, bit for bit, with any number of workers. Ctrl-C leaves a campaign
that can be reported and replayed.
"""


@click.command(name="evolve", help=_HELP)
@mission_argument
@generated_option
@click.option(
    "--case",
    default="a",
    show_default=True,
    metavar="a|b|FILE",
    help="Campaign file: case_NAME.toml beside the models, or any TOML file.",
)
@click.option("--seed", type=int, help="Seed of the search.")
@click.option("--mission-seed", type=int, help="Seed of the mission's weather.")
@click.option("--algorithm", type=click.Choice(list(ALGORITHMS)), help="How to search.")
@click.option("--generations", type=int, help="Generations after the first.")
@click.option("--population", type=int, help="Individuals of a generation.")
@click.option("--evaluations", type=int, help="Stop after exactly so many evaluations.")
@click.option(
    "--workers",
    type=click.IntRange(1),
    help="Processes that evaluate [default: as many as this machine has processors].",
)
@click.option("--engine", type=click.Choice(ENGINES), default=ENGINES[0], show_default=True)
@click.option(
    "--out",
    type=click.Path(path_type=Path, file_okay=False),
    metavar="DIR",
    help="New folder of the campaign [default: runs/NAME-CASE-N, first free N].",
)
@click.option("--ratio", metavar="G:H=M:N", help="Also pick from the front, such as g3:g1=2:1.")
@click.option("--json", "is_json", is_flag=True, help="Print the summary for a script.")
def command(
    mission: str,
    generated: Path | None,
    case: str,
    *,
    workers: int | None,
    engine: str,
    out: Path | None,
    ratio: str | None,
    is_json: bool,
    **overrides: object,
) -> None:
    """Evolve fault specifications against a mission and print the most critical."""
    folders = find_mission(mission, generated)
    settings = CampaignSettings.load(_campaign_file(folders, case), **overrides)
    flown = folders.load().mission
    require_settings(settings, flown)
    _require_ratio(flown, ratio)
    path = free_folder(folders.name, Path(case).stem) if out is None else out
    folder = CampaignFolder.create(path, folders.models, folders.generated)
    with CampaignStore.create(path, settings.as_json(), manifest(folders, case, engine)) as store:
        campaign = OpenCampaign(folder, store, load_code(folder.generated))
        _search(campaign, settings, workers or os.cpu_count() or 1)
    with open_campaign(path) as campaign:
        report(campaign, ratio, is_json=is_json)


def _campaign_file(folders: MissionFolders, case: str) -> Path:
    named = folders.models / f"case_{case}.toml"
    if named.is_file():
        return named
    if Path(case).is_file():
        return Path(case)
    known = [path.stem.removeprefix("case_") for path in folders.models.glob("case_*.toml")]
    message = (
        f"--case: found no campaign file '{case}'; expected the path of a TOML file, or one of: "
        f"{', '.join(sorted(known)) or f'(there is no case_*.toml in {folders.models})'}"
    )
    raise UsageError(message)


def _require_ratio(mission: Mission, ratio: str | None) -> None:
    """Refuse a ratio that makes no sense before the search, not after it."""
    if ratio is not None:
        goal_columns(mission, parse_ratio(ratio).goals)


def _search(campaign: OpenCampaign, settings: CampaignSettings, n_workers: int) -> None:
    path, code = campaign.folder.path, campaign.code
    tell(f"campaign {path}: {settings.algorithm}, seed {settings.seed}, {n_workers} workers")
    try:
        with (
            WorkerPool(code.directory, settings.mission_seed, n_workers) as pool,
            search_progress(settings) as on_generation,
        ):
            run_campaign(
                settings,
                code.mission,
                code.pool,
                pool.evaluate_many,
                campaign.store,
                on_generation,
            )
    except KeyboardInterrupt:
        tell(f"what was found until now is kept; see it with: mrsfi report {path}")
        raise
