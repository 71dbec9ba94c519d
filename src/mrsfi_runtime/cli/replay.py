"""The command ``mrsfi replay``."""

from pathlib import Path

import click
from rich.progress import track

from mrsfi.campaign_folders import (
    FlyableCampaign,
    OpenCampaign,
    find_evaluation,
    open_to_fly,
    require_same,
)
from mrsfi_runtime.cli.console import print_json, tell
from mrsfi_runtime.cli.engines import EngineOptions, FlightFiles
from mrsfi_runtime.cli.recorded_flight import Subject, fly_recorded
from mrsfi_runtime.cli.tables import fault_tables, faults_as_json, goal_table, goals_as_json
from mrsfi_runtime.cli.terminal import print_table, progress_console
from mrsfi_runtime.engine.flights import Engine
from mrsfi_runtime.record.named_faults import named_faults
from mrsfi_runtime.record.store import Evaluation


def replay(
    folder: Path,
    *,
    engine: EngineOptions,
    evaluation: int | None,
    best: bool,
    is_all: bool,
    files: FlightFiles,
    is_json: bool,
) -> None:
    """Fly evaluations of a campaign again and compare them with their record."""
    if sum((evaluation is not None, best, is_all)) > 1:
        raise click.UsageError("--evaluation, --best and --all exclude each other")
    if is_all:
        files.require_none("--all")
    with open_to_fly(folder, tell) as campaign:
        recorded_by = campaign.store.manifest.engine
        chosen = engine.settings(recorded_by if recorded_by.is_foreign else None)
        with chosen.open(campaign.code, campaign.store.settings.mission_seed) as opened:
            if is_all:
                _replay_all(campaign, opened, is_json=is_json)
                return
            recorded = find_evaluation(campaign, evaluation)
            title = f"evaluation {recorded.index} of {folder}"
            again = ("mrsfi", "replay", str(folder), "--evaluation", str(recorded.index))
            outcome = fly_recorded(
                opened, recorded.specification, campaign.pool, files, Subject(title, again)
            )
        require_same(folder, recorded, outcome)
        _print_one(campaign, recorded, is_json=is_json)


def _replay_all(campaign: FlyableCampaign, engine: Engine, *, is_json: bool) -> None:
    n_evaluations = campaign.store.n_evaluations
    recorded = campaign.store.evaluations()
    console = progress_console()
    disable = not console.is_terminal
    for each in track(recorded, "replay", n_evaluations, console=console, disable=disable):
        require_same(campaign.folder.path, each, engine.evaluate(each.specification))
    digest = campaign.store.digest()
    if is_json:
        print_json({"n_evaluations": n_evaluations, "is_same": True, "digest": digest})
    else:
        click.echo(f"same: all {n_evaluations} evaluations, campaign digest {digest}")


def _print_one(campaign: OpenCampaign, recorded: Evaluation, *, is_json: bool) -> None:
    mission, outcome = campaign.mission, recorded.outcome
    faults = named_faults(mission, campaign.pool, recorded.specification)
    if is_json:
        print_json(
            {
                "evaluation": recorded.index,
                "generation": recorded.generation,
                "fitness": list(recorded.fitness),
                "is_same": True,
                "digest": outcome.digest,
                "goals": goals_as_json(mission, outcome),
                "faults": faults_as_json(faults, outcome),
            }
        )
        return
    title = (
        f"Evaluation {recorded.index} of {campaign.folder.path}, generation "
        f"{recorded.generation}, fitness {recorded.fitness[0]:.2f}"
    )
    print_table(title, goal_table(mission, outcome))
    print_table("Faults", *fault_tables(faults, outcome))
    click.echo(f"same as recorded, digest {outcome.digest}")
