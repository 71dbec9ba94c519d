"""What ``mrsfi check`` takes."""

from pathlib import Path
from typing import Any

import click

from mrsfi_runtime.cli.commands.missions import generated_option
from mrsfi_runtime.cli.engines import engine_options
from mrsfi_runtime.engine.settings import AUTO
from mrsfi_runtime.record.manifest import BOTH, CI

_HELP = """Fly every kept weakness of MISSION against today's models and code.

Without MISSION it goes through all of models/. Where a goal has more violations than is kept, the
weakness came back: it says why, and ends with exit code 10. What cannot be judged any more, because
a robot or mission.xmi is gone, say, or a window lies beyond the mission, is an error: the others
are flown all the same, and the exit code is the lowest of such. Nothing kept is no pass either.

\b
Examples:
  mrsfi check
  mrsfi check uuv_sampling --junit regressions.xml
  mrsfi check uuv_sampling --engine reference --seeds 5
  mrsfi check uuv_sampling --json | jq '.uuv_sampling[].state'
"""


@click.command(name="check", help=_HELP)
@click.argument("mission", metavar="[MISSION]", required=False)
@generated_option
@click.option(
    "--seeds",
    "n_seeds",
    type=click.IntRange(1, 1000),
    metavar="N",
    help="Fly in N mission seeds: those that are kept first, then others, of which limits say "
    "nothing unless they hold there too.",
)
@click.option(
    "--junit",
    type=click.Path(path_type=Path, dir_okay=False),
    metavar="FILE",
    help="Write the verdicts to FILE as XML for a build server.",
)
@engine_options(BOTH, CI, default=AUTO)
@click.option("--json", "is_json", is_flag=True, help="Print the verdicts for a script.")
def command(**given: Any) -> None:
    """Fly every kept weakness."""
    from mrsfi_runtime.cli.check import check

    check(**given)
