"""What ``mrsfi compare`` takes."""

from pathlib import Path
from typing import Any

import click

from mrsfi_runtime.cli.options import (
    engine_options,
    generated_option,
    mission_argument,
    worker_options,
)
from mrsfi_runtime.engine.settings import AUTO
from mrsfi_runtime.record.manifest import BOTH

_HELP = """Compare search algorithms on MISSION: several seeds, as many evaluations for each.

Every algorithm searches with the seeds 1 to --seeds, all else as the campaign file says.
Prints medians with quartiles, and for every two algorithms the Mann-Whitney U test, its
p-value, the same adjusted for several tests on one measure (Holm), and A12: the chance that a
run of the first does better than one of the second.

\b
Examples:
  mrsfi compare uuv_sampling
  mrsfi compare uuv_sampling --case b --algorithms paper,random,drift --seeds 10
  mrsfi compare uuv_sampling --seeds 5 --evaluations 200 --out runs/quick
  mrsfi compare uuv_sampling --json | jq '.tests[] | select(.measure == "fitness")'

A comparison that was ended goes on with the same command; a run that is finished is not made
again, also when algorithms or seeds are added. Any run can be had by itself, with the same
digest: mrsfi evolve MISSION --algorithm NAME --seed N --evaluations M.
"""


@click.command(name="compare", help=_HELP)
@mission_argument
@generated_option
@click.option(
    "--case",
    default="a",
    show_default=True,
    metavar="a|b|FILE",
    help="Campaign file: case_NAME.toml beside the models, or any TOML file.",
)
@click.option(
    "--algorithms",
    default="paper,random,drift",
    show_default=True,
    metavar="NAME,NAME,…",
    help="Algorithms, as in a campaign file.",
)
@click.option(
    "--seeds",
    type=click.IntRange(1),
    default=30,
    show_default=True,
    help="Runs of each algorithm, with seeds 1, 2, …",
)
@click.option(
    "--evaluations",
    type=click.IntRange(1),
    default=909,
    show_default=True,
    help="Evaluations of each run.",
)
@worker_options
@engine_options(BOTH, default=AUTO)
@click.option(
    "--out",
    type=click.Path(path_type=Path, file_okay=False),
    metavar="DIR",
    help="Folder of the comparison, new or to go on with [default: runs/compare-NAME-CASE].",
)
@click.option("--json", "is_json", is_flag=True, help="Print the comparison for a script.")
def command(**given: Any) -> None:
    """Compare search algorithms on a mission."""
    from mrsfi_runtime.cli.compare import compare_algorithms

    compare_algorithms(**given)
