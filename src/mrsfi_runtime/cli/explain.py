"""The command ``mrsfi explain``: which faults of a specification break which goal, and why."""

from pathlib import Path
from typing import TYPE_CHECKING

import click

from mrsfi.engines import Given, again, chosen
from mrsfi_runtime.causes.cause_set import KEEP
from mrsfi_runtime.cli.console import print_json, tell
from mrsfi_runtime.cli.options import (
    OneOf,
    engine_options,
    file_option,
    folder_option,
    generated_option,
    worker_options,
)
from mrsfi_runtime.errors import UsageError
from mrsfi_runtime.record.engine_settings import AUTO, Workers
from mrsfi_runtime.record.settings import VIOLATIONS

if TYPE_CHECKING:
    from collections.abc import Sequence

    from mrsfi.explaining import Explainer, NamedSpecification
    from mrsfi_runtime.record.engine_settings import EngineSettings


@click.command(name="explain")
@click.argument("target", metavar="RUN|MISSION")
@generated_option
@file_option("--faults", "Explain this fault specification of MISSION.")
@click.option("--best", is_flag=True, help="The most critical evaluation of RUN, as without it.")
@click.option("--all", "is_all", is_flag=True, help="All the ways in which goals of RUN break.")
@click.option("--evaluation", type=click.IntRange(0), metavar="N", help="Evaluation N of RUN.")
@click.option("--top", "n_top", type=click.IntRange(1), metavar="K", help="The K most critical.")
@click.option(
    "--keep",
    type=click.FloatRange(0.0, 1.0, min_open=True),
    default=KEEP,
    show_default=True,
    help="Share of its violations that a cause set keeps of every goal.",
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
@folder_option(
    "--out",
    "Where to write the cause sets [default: RUN/causes, or the folder of FILE; kept "
    "weaknesses need one].",
)
@worker_options
@engine_options(default=AUTO)
@click.option("--json", "is_json", is_flag=True, help="Print the result for a script.")
def command(  # noqa: PLR0913 - one parameter per option
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

    RUN is the folder of a campaign, whose most critical specification is explained, or those that
    an option names. With --faults, MISSION is a mission, and FILE a fault specification in XMI: one
    that search found, or one written by hand.

    \b
    Examples:
      mrsfi explain runs/uuv_sampling-a-1
      mrsfi explain runs/uuv_sampling-a-1 --evaluation 412
      mrsfi explain runs/uuv_sampling-a-1 --top 10 --json
      mrsfi explain runs/uuv_sampling-a-1 --all
      mrsfi explain uuv_sampling --faults models/uuv_sampling/mine.xmi --measure masked

    The cause set are the faults without which the violations would not be: flown alone, they keep a
    share of every goal's violations, believed (or what the campaign measures) and true ones alike,
    and without any single one of them they do not. It is written as XMI, and beside it its simplest
    form, with shorter windows and plainer values: fly them with mrsfi simulate --faults. Labels say
    what each fault is to each goal:

    \b
      sole       in the goal's cause set, and enough alone
      joint      in the goal's cause set with others
      redundant  could take the place of one in it
      masking    without it there would be more violations
      lesser     none of these, but alone it breaks the goal: others break it more, or hide it
      bystander  none of these

    With --all it is about none of them, but about all the ways in which goals break: what is not
    known yet is flown and recorded, as at the end of mrsfi evolve, and printed as by mrsfi
    weaknesses.
    """
    from mrsfi import explaining
    from mrsfi.campaign_folders import open_to_fly
    from mrsfi.folders import find_mission

    selected = {
        "--best": best or None,
        "--all": is_all or None,
        "--evaluation": evaluation,
        "--top": n_top,
    }
    given = [option for option, value in selected.items() if value is not None]
    if len(given) > 1:
        raise click.UsageError(f"{' and '.join(given)} exclude each other")
    if faults is not None:
        if given:
            raise click.UsageError(f"{given[0]} is about a campaign; --faults names a file")
        settings = chosen(engine, AUTO)
        folders = find_mission(target, generated)
        explainer, one = explaining.explainer_of_file(folders, faults, kind, seed, out, tell)
        _explain(explainer, [one], settings, workers, keep, is_json=is_json)
        return
    if seed is not None or generated is not None:
        option = "--generated" if seed is None else "--seed"
        raise click.UsageError(
            f"{option} needs --faults; a campaign has code and mission seed of its own"
        )
    if is_all:
        _harvest(_run(target), engine, workers, is_json=is_json)
        return
    with open_to_fly(_run(target), tell) as campaign:
        settings = again(engine, campaign.store.manifest.engine)
        some = [*explaining.evaluations_of(campaign, evaluation, n_top or 1)]
        explainer = explaining.explainer_of_campaign(campaign, kind, out)
        fitness = campaign.store.settings.fitness
        if ":" in fitness:
            about = explainer.measure.words
            tell(f"fitness {fitness} plays no part: causes are about {about}")
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
    from mrsfi_runtime.cli.explained import Shown, as_json, print_explanation

    told = []
    for each, found in explained(explainer, specifications, engine, workers, keep, tell):
        paths = explainer.write_sets(each, found)
        shown = Shown(explainer.code, explainer.measure, each.title, each.faults, keep, paths)
        if is_json:
            told.append(as_json(shown, found))
        else:
            print_explanation(shown, found)
    if is_json:
        print_json({"explanations": told})


def _harvest(run: Path, engine: Given, workers: Workers, *, is_json: bool) -> None:
    from mrsfi.explaining import flying_again, harvest, harvested
    from mrsfi_runtime.cli.ways import print_all
    from mrsfi_runtime.record.database import CampaignFolder, only_writer

    with (
        only_writer(CampaignFolder(run)),
        flying_again(run, engine, workers, tell) as (campaign, evaluator, own),
    ):
        harvest(campaign, evaluator, own, tell)
        known = harvested(campaign)
        if is_json:
            print_json([each for way in known.ways for each in way.as_json()])
        else:
            print_all(campaign, known, known.ways, campaign.mission.goal_ids)
