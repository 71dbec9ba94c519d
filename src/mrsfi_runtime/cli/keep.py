"""The command ``mrsfi keep``: keeps a weakness beside the models, and takes new limits over."""

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import click

from mrsfi.engines import Given, again, chosen
from mrsfi_runtime.cli.console import tell
from mrsfi_runtime.cli.options import engine_options, seeds_option
from mrsfi_runtime.record.engine_settings import AUTO

if TYPE_CHECKING:
    from mrsfi_runtime.record.regressions import Regression

_MOST_DIGITS = 99


def _limits(_: click.Context, __: click.Parameter, text: str | None) -> dict[str, int] | None:
    if text is None:
        return None
    limits = {}
    for part in text.split(","):
        goal, _equals, ticks = part.strip().partition("=")
        if not goal or not ticks.isdecimal() or len(ticks) > _MOST_DIGITS:
            message = f"found '{part.strip()[:_MOST_DIGITS]}'; expected GOAL=TICKS, such as g2=0"
            raise click.BadParameter(message)
        limits[goal] = int(ticks)
    return limits


@click.command(name="keep")
@click.argument("target", metavar="CAMPAIGN|MISSION")
@click.option("--weakness", type=click.IntRange(1), metavar="N", help="Weakness N of the campaign.")
@click.option("--name", metavar="NAME", help="Name of its files [default: CAMPAIGN-weakness-N].")
@click.option(
    "--max",
    "limits",
    metavar="G=N,…",
    callback=_limits,
    help="Limit these goals alone, to so many ticks each.",
)
@seeds_option("Limits are the most over N mission seeds; with --update, those of each so far.")
@click.option(
    "--because", "accepted", default="", metavar="TEXT", help="Why these limits are accepted."
)
@click.option("--update", is_flag=True, help="Take over what is counted today of MISSION's.")
@engine_options(default=AUTO)
def command(
    target: str,
    weakness: int | None,
    name: str | None,
    limits: Mapping[str, int] | None,
    n_seeds: int | None,
    accepted: str,
    update: bool,
    engine: Given,
) -> None:
    """Keep a weakness of CAMPAIGN, so that mrsfi check tells when it comes back.

    N is its number in mrsfi weaknesses. The faults go into models/NAME/regressions/ as XMI, and
    beside them the limit: how many ticks of violations the goal may have at most, as many as it has
    today unless --max says otherwise; with 0 the check fails until the weakness is gone. Both are
    files to be reviewed and committed.

    After a change that is wanted, --update takes over what is counted today, and prints the
    difference.

    \b
    Examples:
      mrsfi keep runs/uuv_sampling-a-1 --weakness 1
      mrsfi keep runs/uuv_sampling-a-1 --weakness 2 --name surfacing --max g2=0,g4=10
      mrsfi keep runs/uuv_sampling-a-1 --weakness 3 --seeds 5
      mrsfi keep uuv_sampling --update
      mrsfi keep uuv_sampling --update --name surfacing --because "the mast is lowered from v2 on"
    """
    from mrsfi.campaign_folders import open_campaign
    from mrsfi.regressions import keep

    if update:
        if weakness is not None or limits is not None:
            raise click.UsageError(
                "--update is about all that is kept; give no weakness, no limits"
            )
        _update(target, name, n_seeds, engine, accepted)
        return
    if weakness is None:
        raise click.UsageError("--weakness N is missing: which weakness of the campaign to keep")
    with open_campaign(Path(target)) as campaign:
        if engine:
            again(engine, campaign.store.manifest.engine)  # also where nothing is flown
        regression = keep(campaign, weakness, name, limits, n_seeds or 1, engine, accepted)
        for oddity in regression.idle(campaign.mission.duration):
            tell(oddity)
    tell(f"kept       {regression.specification}")
    tell(f"limits     {regression.path}")


def _update(
    mission: str, name: str | None, n_seeds: int | None, engine: Given, accepted: str
) -> None:
    from mrsfi.folders import find_mission
    from mrsfi.regressions import update

    settings = chosen(engine, AUTO)
    changed = update(find_mission(mission), settings, tell, n_seeds, name, accepted)
    for before, new in changed:
        _print_change(before, new)
    if not changed:
        click.echo("no difference")


def _print_change(before: "Regression", new: "Regression") -> None:
    click.echo(before.name)
    if new.mission_seeds != before.mission_seeds:
        n_before, n_new = len(before.mission_seeds), len(new.mission_seeds)
        click.echo(f"  mission seeds: {n_before} → {n_new}")
    if new.accepted != before.accepted:
        click.echo(f"  accepted because {new.accepted}")
    for goal, ticks in new.limits.items():
        if ticks != before.limits[goal]:
            click.echo(f"  {goal}: {before.limits[goal]} → {ticks}")
