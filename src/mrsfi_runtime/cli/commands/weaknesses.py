"""What ``mrsfi weaknesses`` takes."""

from pathlib import Path
from typing import Any

import click

from mrsfi_runtime.cli.engines import engine_options, worker_options
from mrsfi_runtime.engine.settings import AUTO
from mrsfi_runtime.record.manifest import BOTH, CI

_HELP = """Print all the ways in which goals break, as a campaign found them.

A weakness is a goal and a least set of faults that breaks it: in what the collective intelligence
believes, in truth, or so that the goal is missed in the end. Shares say of how many forms that were
tried, of other values and windows, as many did; one of them is shown. A goal that is broken already
without faults is broken by those that make it worse by 5 % of the mission's ticks. A set holds in a
mission seed if the form shown breaks the goal there, and no part of it does; five were looked at,
or with --seeds as many as it says. Since is the tick at which the form shown first breaks it.

With --mildest, of each set the form is sought, in some 30 flights, that is nearest to what is true
and at work for the fewest ticks, and still breaks the goal in three mission seeds. --fmea tells
that form where it is known, of all sets with --mildest, or else the one shown.

Every campaign looks for them at its end; with --algorithm cover it does nothing else. One that was
not let to, or of an earlier mrsfi, does so with: mrsfi explain RUN --all

\b
Examples:
  mrsfi weaknesses runs/cover
  mrsfi weaknesses runs/cover --goal g2
  mrsfi weaknesses runs/cover --seeds 5
  mrsfi weaknesses runs/cover --goal g2 --mildest
  mrsfi weaknesses runs/cover --map 3 runs/map.png
  mrsfi weaknesses runs/cover --fmea runs/fmea.csv --fault-tree runs/trees.xml
  mrsfi weaknesses runs/cover --bounds --json
  mrsfi weaknesses runs/cover --json | jq '.[] | select(.masked)'
"""

_FILE = click.Path(path_type=Path, dir_okay=False)


@click.command(name="weaknesses", help=_HELP)
@click.argument("run", metavar="RUN", type=click.Path(path_type=Path))
@click.option("--goal", metavar="G", help="Of this goal alone.")
@click.option(
    "--seeds", "n_seeds", type=click.IntRange(1, 1000), metavar="N", help="Fly in N mission seeds."
)
@click.option("--mildest", "is_mildest", is_flag=True, help="Find the least that does it.")
@click.option(
    "--map",
    "drawn",
    type=(int, _FILE),
    metavar="N FILE",
    help="Draw which values and windows of number N do: .csv, .png, .svg.",
)
@click.option("--fmea", type=_FILE, metavar="FILE", help="Write failure modes: .csv or .md.")
@click.option("--fault-tree", type=_FILE, metavar="FILE", help="Write .xml, or .txt for pfta.")
@worker_options
@engine_options(BOTH, CI, default=AUTO)
@click.option("--bounds", "is_bounds", is_flag=True, help="With --json: what was not found.")
@click.option("--json", "is_json", is_flag=True, help="Print them for a script.")
def command(**given: Any) -> None:
    """Print all the ways in which goals break."""
    from mrsfi_runtime.cli.weaknesses import weaknesses

    weaknesses(**given)
