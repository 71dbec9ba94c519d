"""The command ``mrsfi replay``."""

from dataclasses import fields
from pathlib import Path
from typing import TYPE_CHECKING

import click

from mrsfi.engines import Given, again
from mrsfi_runtime.cli.console import print_json, tell
from mrsfi_runtime.cli.options import FlightFiles, engine_options, recording_options
from mrsfi_runtime.engine.opening import open_engine
from mrsfi_runtime.record.engine_settings import REFERENCE

if TYPE_CHECKING:
    from mrsfi.campaign_folders import FlyableCampaign
    from mrsfi_runtime.engine.flights import Engine


@click.command(name="replay")
@click.argument("folder", metavar="CAMPAIGN", type=click.Path(path_type=Path))
@click.option("--evaluation", type=click.IntRange(0), metavar="N", help="Evaluation N.")
@click.option("--best", is_flag=True, help="The most critical evaluation, as without options.")
@click.option("--all", "is_all", is_flag=True, help="Every evaluation.")
@recording_options
@engine_options()
@click.option("--json", "is_json", is_flag=True, help="Print the result for a script.")
def command(
    folder: Path,
    engine: Given,
    evaluation: int | None,
    best: bool,
    is_all: bool,
    files: FlightFiles,
    is_json: bool,
) -> None:
    """Fly evaluations of CAMPAIGN again and compare them with their record, bit for bit.

    The flight uses the campaign's own copies of models and code, so it is the same whatever was
    edited since. A difference ends with exit code 7 and says what differs; a campaign of other
    rules of the world ends with exit code 9 and says which mrsfi flies it.

    \b
    Examples:
      mrsfi replay runs/uuv_sampling-a-1                    the most critical specification
      mrsfi replay runs/uuv_sampling-a-1 --evaluation 412 --log flight.log --trace flight.csv
      mrsfi replay runs/uuv_sampling-a-1 --all              every evaluation
    """
    from mrsfi.campaign_folders import find_evaluations, open_to_fly, require_same
    from mrsfi_runtime.cli.recorded_flight import Subject, fly_recorded, print_flight

    if sum((evaluation is not None, best, is_all)) > 1:
        raise click.UsageError("--evaluation, --best and --all exclude each other")
    if is_all and files.wanted:
        names = ", ".join(f"--{field.name}" for field in fields(files))
        raise click.UsageError(f"{names} are of one flight; --all flies many")
    with open_to_fly(folder, tell) as campaign:
        flown_by = again(engine, campaign.store.manifest.engine, REFERENCE)
        with open_engine(flown_by, campaign.code, campaign.store.settings.mission_seed) as opened:
            if is_all:
                _replay_all(campaign, opened, is_json=is_json)
                return
            (recorded,) = find_evaluations(campaign, evaluation)
            specification, number = recorded.specification, recorded.index
            words = ("mrsfi", "replay", str(folder), "--evaluation", str(number))
            subject = Subject(f"evaluation {number} of {folder}", words)
            outcome = fly_recorded(opened, specification, campaign.pool, files, subject)
        require_same(folder, recorded, outcome)
    title = (
        f"Evaluation {number} of {folder}, generation "
        f"{recorded.generation}, fitness {recorded.fitness[0]:.2f}"
    )
    head = {
        "evaluation": number,
        "generation": recorded.generation,
        "fitness": list(recorded.fitness),
        "is_same": True,
        "digest": outcome.digest,
    }
    told = head if is_json else None
    print_flight(campaign.mission, campaign.pool, specification, outcome, title, told)
    if not is_json:
        click.echo(f"same as recorded, digest {outcome.digest}")


def _replay_all(campaign: "FlyableCampaign", engine: "Engine", *, is_json: bool) -> None:
    from rich.progress import track

    from mrsfi.campaign_folders import fly_all
    from mrsfi_runtime.cli.terminal import progress_console

    n_evaluations = campaign.store.n_evaluations
    flown = fly_all(campaign, engine)
    console = progress_console()
    disable = not console.is_terminal
    for _ in track(flown, "replay", n_evaluations, console=console, disable=disable):
        pass
    digest = campaign.store.digest()
    if is_json:
        print_json({"n_evaluations": n_evaluations, "is_same": True, "digest": digest})
    else:
        click.echo(f"same: all {n_evaluations} evaluations, campaign digest {digest}")
