"""Commands that keep weaknesses, and check them.

The command ``mrsfi keep``: keeps a weakness beside the models, and takes new limits over.

The command ``mrsfi check``: flies what is kept, and fails where a weakness came back.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import click

from mrsfi.engines import Given, again, chosen
from mrsfi_runtime.cli.options import (
    engine_options,
    file_option,
    generated_option,
    seeds_option,
)
from mrsfi_runtime.cli.terminal import print_json, tell
from mrsfi_runtime.errors import LimitExceeded, UsageError
from mrsfi_runtime.record.engine_settings import AUTO

if TYPE_CHECKING:
    from collections.abc import Sequence

    from mrsfi.regressions import Checked
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
def keep_command(
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


@click.command(name="check")
@click.argument("mission", metavar="[MISSION|ARCHIVE]", required=False)
@generated_option
@seeds_option(
    "Fly in N mission seeds: those that are kept first, then others, of which limits say "
    "nothing unless they hold there too."
)
@file_option("--junit", "Write the verdicts to FILE as XML for a build server.")
@click.option(
    "--digest",
    metavar="HEX",
    help="Refuse an ARCHIVE unless mrsfi pack printed this digest for it.",
)
@click.option("--github", is_flag=True, help="Also annotate lines of models, for GitHub Actions.")
@engine_options(default=AUTO)
@click.option("--json", "is_json", is_flag=True, help="Print the verdicts for a script.")
def check_command(
    mission: str | None,
    generated: Path | None,
    engine: Given,
    n_seeds: int | None,
    junit: Path | None,
    digest: str | None,
    github: bool,
    is_json: bool,
) -> None:
    """Fly every kept weakness of MISSION against today's models and code.

    Without MISSION it goes through all of models/. Where a goal has more violations than is kept,
    the weakness came back: it says why, and ends with exit code 10. What cannot be judged any more,
    because a robot or mission.xmi is gone, say, or a window lies beyond the mission, is an error:
    the others are flown all the same, and the exit code is the lowest of such. Nothing kept is no
    pass either.

    The files of an archive of mrsfi pack are compared with its list of their hashes. Then its
    campaign is made once more, by the code in the archive, and compared with what is recorded:
    evaluations, failures, flights, fitness, weaknesses, summary. Whoever changes another file and
    the list changes the digest that mrsfi pack printed; --digest compares it. Options of kept
    weaknesses are refused.

    \b
    Examples:
      mrsfi check
      mrsfi check uuv_sampling --junit regressions.xml
      mrsfi check uuv_sampling --engine reference --seeds 5
      mrsfi check uuv_sampling --json | jq '.uuv_sampling[].state'
      mrsfi check for-the-paper.zip --digest 3f0c…
    """
    from mrsfi.folders import find_mission
    from mrsfi.regressions import check_all, missions_with_kept
    from mrsfi_runtime.cli import verdicts

    if mission is not None and mission.endswith(".zip"):
        is_of_kept = bool(generated or n_seeds or junit or github)
        _repeat(Path(mission), engine, digest, is_of_kept=is_of_kept, is_json=is_json)
        return
    if digest is not None:
        raise click.UsageError("--digest is of an archive of mrsfi pack; expected ARCHIVE")
    if mission is None and generated is not None:
        raise click.UsageError("--generated needs MISSION")
    settings = chosen(engine, AUTO)
    places = [*missions_with_kept()] if mission is None else [find_mission(mission, generated)]
    if not places:
        raise UsageError(
            "found nothing that is kept in models/*/regressions/; expected at least one weakness; "
            "keep one with: mrsfi keep CAMPAIGN --weakness 1"
        )
    found = {each.name: [*check_all(each, settings, tell, n_seeds)] for each in places}
    if junit is not None:
        verdicts.write_junit(junit, found)
        tell(f"written    {junit}")
    every = [each for checked in found.values() for each in checked]
    if is_json:
        told = {name: [*map(verdicts.as_json, checked)] for name, checked in found.items()}
        print_json(told)
    else:
        verdicts.print_tables(found)
    if github:
        verdicts.print_annotations(every)
    _end(every)


def _repeat(
    archive: Path, engine: Given, digest: str | None, *, is_of_kept: bool, is_json: bool
) -> None:
    from mrsfi.campaign import repeat

    if is_of_kept:
        raise click.UsageError(
            f"{archive} is an archive, flown as recorded: --generated, --seeds, --junit and "
            "--github are of kept weaknesses"
        )
    numbers, campaign, found = repeat(archive, engine, digest, tell)
    if is_json:
        print_json({"is_same": True, "digest": campaign, "archive": found, "numbers": numbers})
        return
    told = ", ".join(f"{n} of {n} {kind}" for kind, n in numbers.items())
    click.echo(f"same: {told}")
    click.echo(f"campaign digest {campaign}")
    wanted = "as given" if digest else "compare it with the one that mrsfi pack printed"
    click.echo(f"archive digest {found}: {wanted}")


def _end(every: "Sequence[Checked]") -> None:
    failures = [each.failure for each in every if each.failure is not None]
    unknown = f"; {len(failures)} cannot be judged" if failures else ""
    back = [each.excess for each in every if each.exceeded]
    if back:
        raise LimitExceeded(f"came back: {'; '.join(back)}{unknown}")
    if failures:
        raise min(failures, key=lambda error: error.exit_code)
