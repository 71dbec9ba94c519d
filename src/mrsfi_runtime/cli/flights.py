"""Commands that fly specifications: simulate, replay, explain, and bridge, a server between sides.

A command declares its options, calls ``mrsfi``, and prints. It imports what it needs when it runs,
so that ``mrsfi --help`` loads no toolchain. ``mrsfi bridge`` is the command of ``mrsfi_bridge``
with the errors of ``mrsfi``; it is made when it is called, because its types load slowly.
"""

from dataclasses import fields
from pathlib import Path
from typing import TYPE_CHECKING

import click

from mrsfi.engines import Given, again, chosen, project
from mrsfi_runtime.cli import options
from mrsfi_runtime.cli.options import SIMULATION, FlightFiles, OneOf
from mrsfi_runtime.cli.terminal import print_json, tell
from mrsfi_runtime.engine.opening import named, open_engine
from mrsfi_runtime.errors import UsageError
from mrsfi_runtime.record.engine_settings import AUTO, REFERENCE, SIDES, EngineSettings, Workers
from mrsfi_runtime.record.settings import KEEP, VIOLATIONS

if TYPE_CHECKING:
    from collections.abc import Sequence

    from mrsfi.campaign_folders import FlyableCampaign
    from mrsfi.explaining import Explainer, NamedSpecification
    from mrsfi_bridge.settings import ServerSettings
    from mrsfi_runtime.engine.flights import Engine
    from mrsfi_runtime.generated_code import MissionCode
    from mrsfi_runtime.model.faults import FaultPool, Specification


@options.command(name="simulate")
@options.mission_argument
@options.generated_option
@click.option("--no-faults", is_flag=True, help="Fly without faults (the default).")
@options.file_option("--faults", "Fly with this fault specification.")
@click.option("--seed", type=click.IntRange(0), default=1, show_default=True, help="Mission seed.")
@options.engine_options(sides=(*SIDES, SIMULATION))
@options.recording_options
@click.option("--json", "is_json", is_flag=True, help="Print the result as JSON.")
def simulate_command(
    mission: str,
    generated: Path | None,
    engine: Given,
    no_faults: bool,
    faults: Path | None,
    seed: int,
    files: FlightFiles,
    is_json: bool,
) -> None:
    """Fly MISSION once and print how often each goal was violated.

    Without --faults it flies without faults. A fault specification is an XMI file: one that a
    search found (runs/NAME/critical/01.xmi), or one written by hand, a copy of the pool whose
    faults have start and finish.

    \b
    Examples:
      mrsfi simulate uuv_sampling
      mrsfi simulate uuv_sampling --seed 7 --log flight.log --trace flight.csv
      mrsfi simulate uuv_sampling --faults runs/uuv_sampling-a-1/critical/01.xmi
      mrsfi simulate uuv_sampling --engine rosbridge

    A violation counts once per goal and tick: believed by the collective intelligence, true in the
    simulation, phantom (a false alarm: believed, not true), masked (undetected: true, not
    believed). A goal fails at the tick from which it can no longer be met; – if it was met.
    """
    from mrsfi.folders import find_mission, load_fresh
    from mrsfi_runtime.cli.recorded_flight import Subject, fly_recorded, print_flight

    if no_faults and faults is not None:
        raise click.UsageError("--no-faults and --faults exclude each other")
    settings = chosen(engine)
    folders = find_mission(mission, generated)
    code = load_fresh(folders)
    if settings.side == SIMULATION:
        if no_faults or faults is not None or files.wanted or is_json:
            raise click.UsageError(
                "--side simulation obeys the other side; give faults, logs and --json to the "
                "command that runs it"
            )
        _serve(folders.name, code, settings)
        return
    again, flown, text = ["mrsfi", "simulate", mission], "without faults", ""
    pool: FaultPool = code.pool
    specification: Specification = ()
    if faults is not None:
        from mrsfi.loading import read_specification

        written = read_specification(faults, code, tell)
        pool, specification, flown = written.pool, written.specification, f"under {faults}"
        again += ["--faults", str(faults)]
        text = faults.read_text(encoding="utf-8", errors="replace")
    lasts = code.mission.units.ticks(code.mission.duration)
    title = f"{folders.name}, {lasts}, seed {seed}, {flown}"
    with open_engine(named(settings, code, seed, tell), code, seed) as flown_by:
        subject = Subject(title, [*again, "--seed", str(seed)], text)
        outcome = fly_recorded(flown_by, specification, pool, files, subject)
    head = {"mission": folders.name, "duration": code.mission.duration, "seed": seed}
    head["digest"] = outcome.digest
    print_flight(code.mission, pool, specification, outcome, title, head if is_json else None)


def _serve(name: str, code: "MissionCode", settings: EngineSettings) -> None:
    from mrsfi_runtime.engine.rosbridge import serve_simulation
    from mrsfi_runtime.transport.topics import without_token

    def on_ready(url: str, _host: object) -> None:
        tell(f"simulation of {name} serves at {without_token(url)}; Ctrl-C ends it")

    serve_simulation(code, settings, on_ready, tell)


@options.command(name="replay")
@click.argument("folder", metavar="CAMPAIGN", type=click.Path(path_type=Path))
@click.option("--evaluation", type=click.IntRange(0), metavar="N", help="Evaluation N.")
@click.option("--best", is_flag=True, help="The most critical evaluation (the default).")
@click.option("--all", "is_all", is_flag=True, help="Every evaluation.")
@options.engine_options()
@options.recording_options
@click.option("--json", "is_json", is_flag=True, help="Print the result as JSON.")
def replay_command(
    folder: Path,
    engine: Given,
    evaluation: int | None,
    best: bool,
    is_all: bool,
    files: FlightFiles,
    is_json: bool,
) -> None:
    """Fly evaluations of CAMPAIGN again and compare them with their record, bit for bit.

    Flights use the campaign's own copies of models and code, so later edits do not matter. If one
    differs, replay prints the difference and ends with exit code 7. For a campaign of other rules
    of the world it ends with exit code 9 and prints which mrsfi can fly it.

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
        raise click.UsageError(f"{names} write one flight; --all flies many")
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
    generation, fitness, digest = recorded.generation, recorded.fitness, outcome.digest
    title = f"Evaluation {number} of {folder}, generation {generation}, fitness {fitness[0]:.2f}"
    head = {"evaluation": number, "generation": generation, "fitness": list(fitness)}
    head |= {"is_same": True, "digest": digest}
    told = head if is_json else None
    print_flight(campaign.mission, campaign.pool, specification, outcome, title, told)
    if not is_json:
        click.echo(f"same as recorded, digest {digest}")


def _replay_all(campaign: "FlyableCampaign", engine: "Engine", *, is_json: bool) -> None:
    from rich.progress import track

    from mrsfi.campaign_folders import fly_all
    from mrsfi_runtime.cli.terminal import progress_console

    n_evaluations, console = campaign.store.n_evaluations, progress_console()
    flown, disable = fly_all(campaign, engine), not console.is_terminal
    for _ in track(flown, "replay", n_evaluations, console=console, disable=disable):
        pass
    digest = campaign.store.digest()
    if is_json:
        print_json({"n_evaluations": n_evaluations, "is_same": True, "digest": digest})
    else:
        click.echo(f"same: all {n_evaluations} evaluations, campaign digest {digest}")


@options.command(name="explain")
@click.argument("target", metavar="RUN|MISSION")
@options.generated_option
@options.file_option("--faults", "Explain this fault specification of MISSION.")
@click.option("--best", is_flag=True, help="The most critical evaluation of RUN (default).")
@click.option("--all", "is_all", is_flag=True, help="Find all weaknesses of RUN instead.")
@click.option("--evaluation", type=click.IntRange(0), metavar="N", help="Evaluation N of RUN.")
@click.option("--top", "n_top", type=click.IntRange(1), metavar="K", help="The K most critical.")
@click.option(
    "--keep",
    type=click.FloatRange(0.0, 1.0, min_open=True),
    default=KEEP,
    show_default=True,
    help="Share of every goal's violations that a cause set keeps.",
)
@click.option(
    "--measure",
    "kind",
    type=OneOf(VIOLATIONS),
    show_default="that of RUN, else believed",
    help="Violations that it keeps beside the true ones.",
)
@click.option(
    "--seed",
    type=click.IntRange(0),
    show_default="that of RUN, else 1",
    help="With --faults: mission seed.",
)
@options.worker_options
@options.engine_options(default=AUTO)
@options.folder_option(
    "--out",
    "Folder for the cause sets [default: RUN/causes, or the folder of FILE unless that holds kept "
    "weaknesses].",
)
@click.option("--json", "is_json", is_flag=True, help="Print the result as JSON.")
def explain_command(  # noqa: PLR0913 - one parameter per option
    *,
    target: str,
    generated: Path | None,
    engine: Given,
    workers: Workers,
    faults: Path | None,
    best: bool,
    is_all: bool,
    evaluation: int | None,
    n_top: int | None,
    keep: float,
    kind: str | None,
    seed: int | None,
    out: Path | None,
    is_json: bool,
) -> None:
    """Find out which faults of a specification break which goal.

    RUN is the folder of a campaign; its most critical specification is explained, or those that an
    option names. With --faults, MISSION is a mission, and FILE a fault specification in XMI, found
    by a search or written by hand.

    \b
    Examples:
      mrsfi explain runs/uuv_sampling-a-1
      mrsfi explain runs/uuv_sampling-a-1 --evaluation 412
      mrsfi explain runs/uuv_sampling-a-1 --all
      mrsfi explain uuv_sampling --faults models/uuv_sampling/mine.xmi --measure masked

    The cause set is a minimal set of its faults: flown alone, they keep a share (--keep) of every
    goal's violations, true ones and believed ones (or those that the campaign counts); without any
    one of them they do not. Two files in XMI hold the cause set and its simplest variant, with
    shorter windows and plainer values: fly them with mrsfi simulate --faults. Labels state the role
    of each fault for each goal:

    \b
      sole       in the goal's cause set, and enough alone
      joint      in the goal's cause set with others
      redundant  could replace one in it
      masking    without it there would be more violations
      lesser     none of these, but it breaks the goal when it is alone
      bystander  none of these

    --all finds all weaknesses of RUN instead: it flies and records what is not recorded yet, as at
    the end of mrsfi evolve, and prints them as mrsfi weaknesses does.
    """
    from mrsfi import explaining
    from mrsfi.campaign_folders import open_to_fly
    from mrsfi.folders import find_mission

    flags = {"--best": best or None, "--all": is_all or None}
    selected = {**flags, "--evaluation": evaluation, "--top": n_top}
    given = [option for option, value in selected.items() if value is not None]
    if len(given) > 1:
        raise click.UsageError(f"{' and '.join(given)} exclude each other")
    if faults is not None:
        if given:
            raise click.UsageError(f"{given[0]} selects from a campaign; --faults names a file")
        settings = chosen(engine, AUTO)
        folders = find_mission(target, generated)
        explainer, one = explaining.explainer_of_file(folders, faults, kind, seed, out, tell)
        _explain(explainer, [one], settings, workers, keep, is_json=is_json)
        return
    if seed is not None or generated is not None:
        option = "--generated" if seed is None else "--seed"
        raise click.UsageError(
            f"{option} needs --faults; a campaign has its own code and mission seed"
        )
    if is_all:
        _harvest(_run(target), engine, workers, is_json=is_json)
        return
    with open_to_fly(_run(target), tell) as campaign:
        settings = again(engine, campaign.store.manifest.engine)
        some = [*explaining.evaluations_of(campaign, evaluation, n_top or 1)]
        explainer = explaining.explainer_of_campaign(campaign, kind, out)
        fitness, about = campaign.store.settings.fitness, explainer.measure.words
        if ":" in fitness:
            tell(f"the fitness {fitness} is not used: causes are found for {about}")
        _explain(explainer, some, settings, workers, keep, is_json=is_json)


def _run(target: str) -> Path:
    from mrsfi.folders import is_mission
    from mrsfi_runtime.record.database import CampaignFolder

    path = Path(target)
    if not CampaignFolder(path).database.is_file() and is_mission(target):
        raise UsageError(
            f"found mission '{target}'; expected the folder of a campaign, or --faults FILE with a "
            "fault specification of the mission"
        )
    return path


def _explain(
    explainer: "Explainer",
    specifications: "Sequence[NamedSpecification]",
    engine: "EngineSettings",
    workers: Workers,
    keep: float,
    *,
    is_json: bool,
) -> None:
    from mrsfi.explaining import explained
    from mrsfi_runtime.cli.campaign_results import Shown, explanation_as_json, print_explanation

    told = []
    for each, found in explained(explainer, specifications, engine, workers, keep, tell):
        paths = explainer.write_sets(each, found)
        shown = Shown(explainer.code, explainer.measure, each.title, each.faults, keep, paths)
        if is_json:
            told.append(explanation_as_json(shown, found))
        else:
            print_explanation(shown, found)
    if is_json:
        print_json({"explanations": told})


def _harvest(run: Path, engine: Given, workers: Workers, *, is_json: bool) -> None:
    from mrsfi.explaining import flying_again, harvest, harvested
    from mrsfi_runtime.cli.campaign_results import print_all
    from mrsfi_runtime.record.database import CampaignFolder, only_writer

    with (
        only_writer(CampaignFolder(run)),
        flying_again(run, engine, workers, tell) as (campaign, evaluator, own),
    ):
        harvest(campaign, evaluator, own, tell)
        known = harvested(campaign)
        if is_json:
            print_json([each for weakness in known.goal_weaknesses for each in weakness.as_json()])
        else:
            print_all(campaign, known.goal_weaknesses, campaign.mission.goal_ids, known)


def bridge_command() -> click.Command:
    """Make the command ``mrsfi bridge``."""
    from mrsfi_bridge.errors import BridgeError
    from mrsfi_bridge.settings import bridge_command as command_of

    def serve_bridge(settings: "ServerSettings") -> None:
        from mrsfi_bridge.embedded import serve

        try:
            serve(settings)
        except BridgeError as error:
            from mrsfi_runtime.transport.rosbridge import as_ours

            raise as_ours(error) from error

    return command_of("mrsfi bridge", serve_bridge, lambda: project().ros)
