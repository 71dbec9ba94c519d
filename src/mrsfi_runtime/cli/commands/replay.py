"""What ``mrsfi replay`` takes."""

from pathlib import Path
from typing import Any

import click

from mrsfi_runtime.cli.engines import engine_options, recording_options
from mrsfi_runtime.record.manifest import BOTH, CI

_HELP = """Fly evaluations of CAMPAIGN again and compare them with their record, bit for bit.

The flight uses the campaign's own copies of models and code, so it is the same whatever was
edited since. A difference ends with exit code 7 and says what differs; a campaign of other rules
of the world ends with exit code 9 and says which mrsfi flies it.

\b
Examples:
  mrsfi replay runs/uuv_sampling-a-1                    the most critical specification
  mrsfi replay runs/uuv_sampling-a-1 --evaluation 412 --log flight.log --trace flight.csv
  mrsfi replay runs/uuv_sampling-a-1 --all              every evaluation
"""


@click.command(name="replay", help=_HELP)
@click.argument("folder", metavar="CAMPAIGN", type=click.Path(path_type=Path))
@click.option("--evaluation", type=click.IntRange(0), metavar="N", help="Evaluation N.")
@click.option("--best", is_flag=True, help="The most critical evaluation, as without options.")
@click.option("--all", "is_all", is_flag=True, help="Every evaluation.")
@recording_options
@engine_options(BOTH, CI)
@click.option("--json", "is_json", is_flag=True, help="Print the result for a script.")
def command(**given: Any) -> None:
    """Fly evaluations of a campaign again and compare them with their record."""
    from mrsfi_runtime.cli.replay import replay

    replay(**given)
