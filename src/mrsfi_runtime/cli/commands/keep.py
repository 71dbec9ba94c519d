"""What ``mrsfi keep`` takes."""

from typing import Any

import click

from mrsfi_runtime.cli.engines import engine_options
from mrsfi_runtime.engine.settings import AUTO
from mrsfi_runtime.record.manifest import BOTH, CI

_HELP = """Keep a weakness of CAMPAIGN, so that mrsfi check tells when it comes back.

N is its number in mrsfi weaknesses. The faults go into models/NAME/regressions/ as XMI, and beside
them the limit: how many ticks of violations the goal may have at most, as many as it has today
unless --max says otherwise; with 0 the check fails until the weakness is gone. Both are files to be
reviewed and committed.

After a change that is wanted, --update takes over what is counted today, and prints the
difference.

\b
Examples:
  mrsfi keep runs/uuv_sampling-a-1 --weakness 1
  mrsfi keep runs/uuv_sampling-a-1 --weakness 2 --name surfacing --max g2=0,g4=10
  mrsfi keep runs/uuv_sampling-a-1 --weakness 3 --seeds 5
  mrsfi keep uuv_sampling --update
  mrsfi keep uuv_sampling --update --name surfacing
"""


def _limits(_: click.Context, __: click.Parameter, text: str | None) -> dict[str, int] | None:
    if text is None:
        return None
    limits = {}
    for part in text.split(","):
        goal, _equals, ticks = part.strip().partition("=")
        if not goal or not ticks.isdecimal():
            message = f"found '{part.strip()}'; expected GOAL=TICKS, such as g2=0"
            raise click.BadParameter(message)
        limits[goal] = int(ticks)
    return limits


@click.command(name="keep", help=_HELP)
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
@click.option(
    "--seeds",
    "n_seeds",
    type=click.IntRange(1, 1000),
    metavar="N",
    help="Limits are the most over N mission seeds; with --update, those of each so far.",
)
@click.option("--update", is_flag=True, help="Take over what is counted today of MISSION's.")
@engine_options(BOTH, CI, default=AUTO)
def command(**given: Any) -> None:
    """Keep a weakness of a campaign."""
    from mrsfi_runtime.cli.keep import keep

    keep(**given)
