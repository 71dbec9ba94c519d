"""Commands that make a campaign and print its results: evolve, report, weaknesses, confirm, pack.

A command declares its options, calls ``mrsfi``, and prints. It imports what it needs when it runs,
so that ``mrsfi --help`` loads no toolchain. One process at a time writes a campaign.
"""

import datetime as dt
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
from click.core import ParameterSource

from mrsfi.engines import Given, chosen
from mrsfi_runtime.cli import options
from mrsfi_runtime.cli.options import FILE, OF_ENGINE, OneOf
from mrsfi_runtime.cli.terminal import print_json, print_table, print_words, tell, write_file
from mrsfi_runtime.errors import TransportError, UsageError, WorkerLost, counted, expected
from mrsfi_runtime.model.faults import COSTS
from mrsfi_runtime.record.engine_settings import (
    AUTO,
    CI,
    INJECTOR,
    ROSBRIDGE,
    EngineSettings,
    Workers,
)
from mrsfi_runtime.record.settings import ALGORITHM_NAMES, COVERING, MINIMISING, VIOLATIONS

if TYPE_CHECKING:
    from contextlib import AbstractContextManager

    from mrsfi.campaign_folders import FlyableCampaign, OpenCampaign
    from mrsfi.confirming import Budget
    from mrsfi_runtime.causes.mildest import GoalWeakness


def _ids(_: click.Context, __: click.Parameter, text: str | None) -> list[str] | None:
    return None if text is None else [each.strip() for each in text.split(",")]


@options.command(name="evolve")
@click.pass_context
@click.argument("mission", metavar="[MISSION]", required=False)
@options.generated_option
@click.option(
    "--resume", type=click.Path(path_type=Path), metavar="DIR", help="Continue the campaign in DIR."
)
@click.option(
    "--explain/--no-explain",
    default=None,
    help="Search for weaknesses and mildest variants at the end, or not: then report and page have "
    "none, and show and keep do not work [default: --explain, or as the campaign was begun].",
)
@click.option(
    "--case", show_default="a", metavar="a|b|FILE", help="Campaign file case_NAME.toml, or any."
)
@click.option("--seed", type=int, help="Seed of the search.")
@click.option("--mission-seed", type=int, help="Mission seed: decides what is random in a flight.")
@click.option(
    "--algorithm",
    metavar="NAME",
    help=f"Search algorithm: {', '.join(ALGORITHM_NAMES)}, or your own as MODULE:FUNCTION.",
)
@click.option("--generations", type=int, help="Generations after the first.")
@click.option("--population", type=int, help="Individuals per generation.")
@click.option("--evaluations", type=int, help="Stop after exactly this number of evaluations.")
@click.option("--until", type=float, metavar="P", help="With cover: stop when all bounds are ≤ P.")
@click.option("--faults", type=int, help="Timed faults per individual (with --minimise, at most).")
@click.option("--goals", metavar="G,H,…", callback=_ids, help="Only these goals.")
@click.option(
    "--protect",
    metavar="ID,…",
    callback=_ids,
    help="Leave out the faults of these robots, messages, sensors or obstacles.",
)
@click.option("--violations", metavar="NAME", help=f"Violations to count: {', '.join(VIOLATIONS)}.")
@click.option(
    "--minimise",
    metavar="|".join(COSTS),
    help=f"Also minimise their number; needs algorithm {' or '.join(MINIMISING)}.",
)
@click.option(
    "--nightly",
    "is_nightly",
    is_flag=True,
    help=f"--algorithm {COVERING}, and exit code 11 if a weakness is neither kept nor decided.",
)
@options.worker_options
@options.engine_options(default=AUTO)
@options.folder_option(
    "--out", "New folder of the campaign [default: runs/NAME-CASE-N, first free N]."
)
@click.option("--ratio", metavar="G:H=M:N", help="Also pick from the Pareto front: g3:g1=2:1.")
@click.option("--json", "is_json", is_flag=True, help="Print the summary as JSON.")
def evolve_command(
    ctx: click.Context,
    /,
    engine: Given,
    workers: Workers,
    resume: Path | None,
    ratio: str | None,
    explain: bool | None,
    is_nightly: bool,
    is_json: bool,
    **given: Any,
) -> None:
    """Search for faults that break the goals of MISSION, and print the weaknesses found.

    A weakness is a goal and a minimal set of faults that breaks it. The campaign file sets
    algorithm, population, generations and fitness. --case a and --case b name the files
    case_a.toml and case_b.toml beside the models; options replace single values. The campaign
    gets a new folder, runs/NAME-CASE-N, with copies of models and code, every evaluation, tables,
    a page, and the ten worst specifications as XMI; mrsfi report also draws figures.

    After the search, mrsfi flies at most as often again (and at most 1000 times) to find all
    weaknesses. Then it shrinks the smallest one of each goal to its mildest variant. It prints
    these first; mrsfi weaknesses prints all. If an external simulation or node does not repeat
    itself, mrsfi only searches.

    \b
    Examples:
      mrsfi evolve uuv_sampling
      mrsfi evolve uuv_sampling --seed 7 --generations 5 --out runs/short
      mrsfi evolve uuv_sampling --algorithm cover --until 0.02
      mrsfi evolve uuv_sampling --algorithm guided --minimise faults --violations true --goals g2
      mrsfi evolve uuv_sampling --case my_campaign.toml --json | jq .best.fitness
      mrsfi evolve uuv_sampling --nightly --seed 41 --until 0.1
      mrsfi evolve --resume runs/uuv_sampling-a-1

    The same seed gives the same result, bit for bit, with any number of workers. A campaign that
    was interrupted (Ctrl-C, kill, power loss) can be reported and replayed. --resume DIR continues
    it: no recorded evaluation is flown again, and the result is that of an uninterrupted run.
    """
    from mrsfi.evolving import evolve
    from mrsfi_runtime.cli.campaign_results import report, require_decided
    from mrsfi_runtime.cli.terminal import search_progress

    if is_nightly:
        if explain is False or given["algorithm"] not in {None, COVERING}:
            raise click.UsageError(f"--nightly needs --algorithm {COVERING} and --explain")
        given["algorithm"] = COVERING
    if resume is None:
        opened = _begun(chosen(engine, AUTO), workers, ratio, **given)
    else:
        opened = _resumed(resume, ctx, engine, workers, ratio)
    with opened as (campaign, flown_by):
        path = campaign.folder.path
        watched = search_progress(campaign.store)
        try:
            evolve(campaign, flown_by, workers, watched, explains=explain, tell=tell)
        except (KeyboardInterrupt, TransportError, WorkerLost):
            if any(campaign.store.next_indexes()):
                tell(f"the results so far are kept; print them with: mrsfi report {path}")
                tell(f"continue with: mrsfi evolve --resume {path}")
            raise
        has_figures = any(campaign.folder.figures.glob("figure_*"))  # of a resumed campaign
        report(campaign, ratio, is_json=is_json, draws=has_figures)
        if is_nightly:
            require_decided(campaign)


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
    from mrsfi.folders import campaign_file, find_mission, load_fresh
    from mrsfi_runtime.record.decisions import decisions_of
    from mrsfi_runtime.record.settings import CampaignSettings

    workers.require_sense(engine)
    if mission is None:
        raise UsageError("found no MISSION; expected one, or --resume DIR to continue a campaign")
    folders, case = find_mission(mission, generated), case or "a"
    decisions_of(folders.models)  # refuses, before the search, what the report could not read
    settings = CampaignSettings.load(campaign_file(folders, case), **overrides)
    code = load_fresh(folders)
    return begun(folders, code, settings, case, engine, out=out, ratio=ratio, tell=tell)


def _resumed(
    path: Path, ctx: click.Context, engine: Given, workers: Workers, ratio: str | None
) -> "AbstractContextManager[tuple[FlyableCampaign, EngineSettings]]":
    from mrsfi.evolving import resumed
    from mrsfi_runtime.record.store import CampaignStore

    with CampaignStore.open(path) as store:  # first: without a campaign there is nothing to lock
        store.require_flyable()
        store.require_repeatable()
        manifest, settings = store.manifest, store.settings
    begun_with = {"mission": manifest.mission, "case": manifest.case, "protect": []}
    begun_with |= settings.as_json()
    _require_same_options(path, ctx, begun_with)
    flown_by = chosen(engine, AUTO, manifest.engine)
    workers.require_sense(flown_by)
    return resumed(path, flown_by, ratio=ratio, tell=tell)


_FREE = {"resume", "ratio", "explain", "is_nightly", "is_json"}  # also of a begun campaign


def _require_same_options(path: Path, ctx: click.Context, recorded: Mapping[str, Any]) -> None:
    for parameter in ctx.command.params:
        name = str(parameter.name)
        is_given = ctx.get_parameter_source(name) is ParameterSource.COMMANDLINE
        if not is_given or name in _FREE | OF_ENGINE:
            continue
        given = ctx.params[name]
        label = parameter.opts[0] if isinstance(parameter, click.Option) else "MISSION"
        if name not in recorded:
            raise UsageError(
                f"{label} {given}: not possible with --resume; {path} continues in its own folder, "
                "with its own copies of models and code; leave it out"
            )
        found = Path(given).name if name == "mission" else given
        if found != recorded[name]:
            raise UsageError(
                f"{label}: found {given}; {path} was begun with {recorded[name]} and continues "
                "with it; leave the option out, or begin a new campaign without --resume"
            )


@click.command(name="report")
@click.argument("folder", metavar="[CAMPAIGN]", required=False, type=click.Path(path_type=Path))
@click.option("--ratio", metavar="G:H=M:N", help="Pick from the Pareto front, such as g3:g1=2:1.")
@click.option(
    "--format",
    "form",
    type=OneOf(("markdown", "latex")),
    default="markdown",
    show_default=True,
    help="latex also writes report.tex and figures as PDF, for a paper.",
)
@click.option("--json", "is_json", is_flag=True, help="Print the summary as JSON.")
def report_command(folder: Path | None, ratio: str | None, form: str, is_json: bool) -> None:
    """Write the report of CAMPAIGN, with figures, and print its weaknesses.

    If the campaign has not searched for weaknesses, it prints the ten most critical specifications.
    CAMPAIGN is the folder of a finished or interrupted campaign; by default the campaign in runs/
    that was written last. The report uses the folder's own copies, so later edits do not matter.

    \b
    Examples:
      mrsfi report
      mrsfi report runs/uuv_sampling-b-1 --ratio g3:g1=2:1
      mrsfi report runs/uuv_sampling-a-1 --format latex

    Written into the folder: report.md, summary.json, figures/, tables/, critical/*.xmi and
    weaknesses/*.xmi.
    """
    from mrsfi.campaign_folders import latest_folder, open_campaign
    from mrsfi_runtime.cli.campaign_results import report

    with open_campaign(folder or latest_folder()) as campaign:
        report(campaign, ratio, is_json=is_json, latex=form == "latex")


@options.command(name="weaknesses")
@click.argument("run", metavar="RUN", type=click.Path(path_type=Path))
@click.option("--goal", metavar="G", help="Only this goal.")
@options.seeds_option("Check each weakness in N mission seeds.")
@click.option("--mildest", "is_mildest", is_flag=True, help="Find mildest variants.")
@click.option(
    "--with",
    "others",
    multiple=True,
    metavar="RUN",
    type=click.Path(path_type=Path),
    help="Estimate how many there are, with another campaign; repeatable.",
)
@options.worker_options
@options.engine_options(default=AUTO)
@click.option(
    "--map",
    "drawn",
    type=(int, FILE),
    metavar="N FILE",
    help="Map of weakness N: .csv, .png, .svg.",
)
@options.file_option("--fmea", "Write failure modes and effects: .csv, .xlsx, .md or .tex.")
@options.file_option("--fault-tree", "Write the fault trees of goals: .xml, or .txt for pfta.")
@click.option("--bounds", "is_bounds", is_flag=True, help="With --json: print the bounds alone.")
@click.option("--json", "is_json", is_flag=True, help="Print them as JSON.")
def weaknesses_command(
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
    """Print the weaknesses that a campaign found: its main result.

    A weakness is a goal and a minimal set of faults that breaks it: the goal is truly violated, or
    fails. A set that only makes the collective intelligence believe so is a false alarm. If a goal
    is violated without faults already, it has to be so for 5 % of the mission's ticks longer.

    A share is the percentage of variants (other values, other windows) that break the goal;
    one of them is shown. A weakness counts in a mission seed if this variant breaks the goal there
    and no part of it does; five seeds are checked, or as many as --seeds says. Since is the first
    tick at which this variant breaks the goal.

    --mildest searches, in some 30 flights for each weakness, for the variant that is closest to the
    truth, is active for the fewest ticks, and still breaks the goal in three mission seeds. --fmea
    describes the mildest variant where it is known, else the one shown.

    --with estimates how many weaknesses there are, found or not, from campaigns that differ in
    --seed, and lists those that RUN lacks. If faults have likelihoods, it adds an upper value to
    the risk that a goal breaks.

    If a campaign was begun with --no-explain, mrsfi explain RUN --all finds its weaknesses.

    \b
    Examples:
      mrsfi weaknesses runs/cover
      mrsfi weaknesses runs/cover --with runs/cover2 --with runs/cover3
      mrsfi weaknesses runs/cover --goal g2 --mildest
      mrsfi weaknesses runs/cover --map 3 runs/map.png    which values and windows break its goal
      mrsfi weaknesses runs/cover --fmea runs/fmea.csv --fault-tree runs/trees.xml
      mrsfi weaknesses runs/cover --bounds --json
      mrsfi weaknesses runs/cover --json | jq '.[] | select(.detection.n_never > 0)'
    """
    from mrsfi.campaign_folders import open_campaign
    from mrsfi.explaining import flying_again, harvested_beside, refined
    from mrsfi_runtime.cli import campaign_results

    others: tuple[Path, ...] = files.pop("others")
    if is_bounds and not is_json:
        raise click.UsageError("--bounds needs --json; else bounds stand below the weaknesses")
    if others and (is_mildest or is_bounds < is_json):
        raise click.UsageError("--with has no effect on --mildest; with --json it needs --bounds")
    with open_campaign(run) as campaign:
        goals = _chosen(goal, campaign.mission.goal_ids)
        known, *beside = harvested_beside(campaign, others)
        found = [each for each in known.goal_weaknesses if each.goal in goals]
        is_told = not is_bounds or any(files.values())
        is_named = bool(engine)  # a named engine has to be the one that flew it
        if is_told and (is_mildest or n_seeds is not None or is_named):
            with flying_again(run, engine, workers, tell) as (flown, evaluator, own):
                found = refined(flown, evaluator, own, found, n_seeds, is_mildest=is_mildest)
        _write(campaign, found, engine, workers, **files)
        if is_bounds:
            campaign_results.print_bounds(campaign.pool, goals, [known, *beside])
        elif is_mildest:
            campaign_results.print_mildest(campaign, found, is_json=is_json)
        elif is_json:
            campaign_results.print_found(campaign, found)
        else:
            again = known.with_seeds_of(found)
            campaign_results.print_all(campaign, found, goals, again, *beside)


def _chosen(goal: str | None, goals: tuple[str, ...]) -> tuple[str, ...]:
    if goal is None:
        return goals
    if goal not in goals:
        raise UsageError(f"--goal: found '{goal}'; {expected(goal, goals)}")
    return (goal,)


def _write(
    campaign: "OpenCampaign",
    found: "Sequence[GoalWeakness]",
    engine: Given,
    workers: Workers,
    drawn: tuple[int, Path] | None = None,
    fmea: Path | None = None,
    fault_tree: Path | None = None,
) -> None:
    from mrsfi import explaining as of
    from mrsfi_runtime.analysis.documents import FAULT_TREES, FMEA

    run, (number, map_path) = campaign.folder.path, drawn or (0, None)
    for path, known in ((fmea, FMEA), (fault_tree, FAULT_TREES), (map_path, of.MAPS)):
        if path is not None:
            of.require_format(path, known)
    shown = of.weakness_of(run, found, number) if map_path else None
    if fault_tree is not None:
        trees = FAULT_TREES[fault_tree.suffix](campaign.mission, campaign.pool, found)
        write_file(fault_tree, trees)
    if fmea is None and map_path is None:
        return
    with of.flying_again(run, engine, workers, tell) as (flown, evaluator, own):
        if fmea is not None:
            from mrsfi.regressions import settled

            decided = settled(flown, found, dt.date.today())
            write_file(fmea, of.fmea_of(flown, found, own.record, decided, fmea.suffix))
        if map_path is not None and shown is not None:
            drawing = of.map_of(flown, evaluator, own.record, shown, map_path.suffix)
            write_file(map_path, drawing)


def _budget(_: click.Context, __: click.Parameter, text: str | None) -> "Budget | None":
    from mrsfi.confirming import Budget

    if text is None:
        return None
    if (found := re.fullmatch(r"([1-9]\d{0,8})([smh]?)", text)) is None:
        what = f"found '{text}'; expected a number of flights, or a time such as 90s, 10m or 2h"
        raise click.BadParameter(what)
    number, unit = int(found[1]), {"s": 1.0, "m": 60.0, "h": 3600.0}.get(found[2])
    return Budget(number) if unit is None else Budget(seconds=number * unit)


@options.command(name="confirm")
@click.argument("run", metavar="RUN", type=click.Path(path_type=Path))
@click.option("--goal", metavar="G", help="Only weaknesses of this goal.")
@click.option(
    "--weakness",
    "numbers",
    type=int,
    metavar="N",
    multiple=True,
    help="Only weakness N; repeatable.",
)
@click.option(
    "--budget",
    metavar="N|TIME",
    callback=_budget,
    help="At most N new flights, or begin none after 90s, 10m or 2h.",
)
@click.option("--anew", "is_anew", is_flag=True, help="Forget what was flown in this world before.")
@options.worker_options
@options.engine_options(default=ROSBRIDGE, sides=(CI, INJECTOR))
@click.option("--json", "is_json", is_flag=True, help="Print the result as JSON.")
def confirm_command(
    run: Path,
    goal: str | None,
    numbers: tuple[int, ...],
    budget: "Budget | None",
    is_anew: bool,
    engine: Given,
    workers: Workers,
    is_json: bool,
) -> None:
    """Fly the weaknesses of RUN in another world, and print which break the same goal there.

    The other world is an external simulation, which --world starts, or one at --url. Each weakness
    flies its listed variant, the gravest weaknesses first. Where that breaks its goal, mrsfi looks
    for the mildest variant that breaks it there.

    Each flight is recorded in RUN as it ends. The same command continues. If equal flights differ
    in that world, each variant is flown three times, and a goal breaks if it breaks in more than
    half of them.

    \b
    Examples:
      mrsfi confirm runs/uuv_sampling-a-1 --world "python world.py {url}" --workers 2
      mrsfi confirm runs/uuv_sampling-a-1 --url ws://127.0.0.1:9090 --budget 10m --goal g2
      mrsfi confirm runs/uuv_sampling-a-1 --url ws://127.0.0.1:9090 --json | jq .share
    """
    from mrsfi import confirming
    from mrsfi.explaining import weakness_of

    def choose(found: "Sequence[GoalWeakness]") -> "list[GoalWeakness]":
        goals = _chosen(goal, tuple(dict.fromkeys(each.goal for each in found)))
        some = [weakness_of(run, found, number) for number in dict.fromkeys(numbers)] or found
        return [each for each in some if each.goal in goals]

    try:
        found = confirming.confirm(run, engine, workers, choose, budget, tell, is_anew=is_anew)
    except (KeyboardInterrupt, TransportError):
        tell(f"flights that ended are kept in {run}; the same command continues")
        raise
    if is_json:
        print_json(confirming.as_json(found))
        return
    print_table(confirming.table(found))
    seconds = confirming.seconds_of(found)
    print_words((f"In {found.world}, {found.transfer.words}", "bold"))
    print_words(f"{counted(len(seconds), 'flights')} there, {sum(seconds):.0f} s of flight")


@options.command(name="monitors")
@click.argument("run", metavar="RUN", type=click.Path(path_type=Path))
@click.option(
    "--fit-seeds",
    "n_fit",
    type=click.IntRange(1, 1000),
    default=20,
    show_default=True,
    metavar="N",
    help="Fit thresholds in N mission seeds without faults.",
)
@click.option("--write", is_flag=True, help="Write them into regions of the mission's code.")
@options.engine_options(default=AUTO)
@click.option("--json", "is_json", is_flag=True, help="Print the result as JSON.")
def monitors_command(run: Path, n_fit: int, engine: Given, *, write: bool, is_json: bool) -> None:
    """Print which monitors would have caught the weaknesses of RUN in time.

    A monitor checks what the collective intelligence receives, such as a position that is frozen.
    Its thresholds are fitted to flights without faults. Then every variant of the weaknesses is
    flown again, and mrsfi prints which monitors to add, first the one that detects most of them no
    later than the goal is broken, what remains, and how often they raise false alarms.

    \b
    Examples:
      mrsfi monitors runs/uuv_sampling-a-1
      mrsfi monitors runs/uuv_sampling-a-1 --fit-seeds 100
      mrsfi monitors runs/uuv_sampling-a-1 --json | jq '.recommended[].monitor'
    """
    from mrsfi import monitoring

    if write:
        monitoring.require_regions(run)
    study = monitoring.monitored(run, engine, n_fit, tell)
    if write:
        tell(f"written    {monitoring.write(run, study)}")
    if is_json:
        print_json(monitoring.as_json(study))
        return
    for sentence in monitoring.sentences(study):
        print_words(sentence)
    click.echo()
    for table in monitoring.tables(study) if study.cases else ():
        print_table(table)


@click.command(name="show")
@click.argument("run", metavar="RUN", type=click.Path(path_type=Path))
@click.argument("number", metavar="[N]", required=False, type=click.IntRange(1))
def show_command(run: Path, number: int | None) -> None:
    """Draw and describe how faults break a goal: weakness N, or the smallest of each goal.

    RUN is the folder of a campaign, N a number that mrsfi weaknesses prints. Its mildest known
    variant is flown on the campaign's own copy of the code. One figure shows time: the faults above
    the goals that they break. The other shows space: the true and the believed paths of the robots.
    A figure that is newer than the campaign's record is not drawn again.

    \b
    Examples:
      mrsfi show runs/uuv_sampling-a-1
      mrsfi show runs/uuv_sampling-a-1 6

    Written into the folder: figures/weakness_* as PNG and SVG, and their numbers into tables/.
    """
    from mrsfi.campaign_folders import open_campaign
    from mrsfi.explaining import harvested, show
    from mrsfi_runtime.cli.campaign_results import print_verdicts

    with open_campaign(run) as campaign:
        found = harvested(campaign)
        if number is None:
            print_verdicts(campaign, found)
        for each in show(campaign, number):
            click.echo(f"{each.weakness.number}  {each.title}")
            for line in (*each.sentences, *each.figures):
                click.echo(f"    {line}")
            click.echo()


@click.command(name="pack")
@click.argument("run", metavar="CAMPAIGN", type=click.Path(path_type=Path))
@options.file_option("--out", "The archive [default: CAMPAIGN.zip, in this folder].")
def pack_command(run: Path, out: Path | None) -> None:
    """Pack CAMPAIGN into one file that can be repeated elsewhere.

    It holds models, generated code, settings, every evaluation, and the versions it was made with.
    mrsfi check FILE flies all of it again, and ends with exit code 7 if anything differs.

    \b
    Examples:
      mrsfi pack runs/uuv_sampling-a-1
      mrsfi pack runs/uuv_sampling-a-1 --out for-the-paper.zip
      mrsfi check for-the-paper.zip
    """
    from mrsfi.campaign import pack

    path = out or Path(f"{run.resolve().name}.zip")
    digest = pack(run, path, tell)
    tell(f"written    {path}")
    click.echo(f"digest     {digest}")
