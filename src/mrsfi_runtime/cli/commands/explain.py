"""What ``mrsfi explain`` takes."""

from pathlib import Path
from typing import Any

import click

from mrsfi_runtime.causes.cause_set import KEEP
from mrsfi_runtime.cli.commands.missions import generated_option
from mrsfi_runtime.cli.engines import OneOf, engine_options, worker_options
from mrsfi_runtime.engine.settings import AUTO
from mrsfi_runtime.record.manifest import BOTH, CI
from mrsfi_runtime.record.settings import VIOLATIONS

_HELP = """Find out which faults of a specification break which goal.

RUN is the folder of a campaign, whose most critical specification is explained, or those that an
option names. With --faults, MISSION is a mission, and FILE a fault specification in XMI: one that
search found, or one written by hand.

\b
Examples:
  mrsfi explain runs/uuv_sampling-a-1
  mrsfi explain runs/uuv_sampling-a-1 --evaluation 412
  mrsfi explain runs/uuv_sampling-a-1 --top 10 --json
  mrsfi explain runs/uuv_sampling-a-1 --all
  mrsfi explain uuv_sampling --faults models/uuv_sampling/mine.xmi --measure masked

The cause set are the faults without which the violations would not be: flown alone, they keep a
share of every goal's violations, believed (or what the campaign measures) and true ones alike, and
without any single one of them they do not. It is written as XMI, and beside it its simplest form,
with shorter windows and plainer values: fly them with mrsfi simulate --faults. Labels say what each
fault is to each goal:

\b
  sole       in the goal's cause set, and enough alone
  joint      in the goal's cause set with others
  redundant  could take the place of one in it
  masking    without it there would be more violations
  lesser     none of these, but alone it breaks the goal: others break it more, or hide it
  bystander  none of these

With --all it is about none of them, but about all the ways in which goals break: what is not known
yet is flown and recorded, as at the end of mrsfi evolve, and printed as by mrsfi weaknesses.
"""


@click.command(name="explain", help=_HELP)
@click.argument("target", metavar="RUN|MISSION")
@generated_option
@click.option(
    "--faults",
    type=click.Path(path_type=Path, dir_okay=False),
    metavar="FILE",
    help="Explain this fault specification of MISSION.",
)
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
@click.option(
    "--out",
    type=click.Path(path_type=Path, file_okay=False),
    metavar="DIR",
    help="Where to write the cause sets [default: RUN/causes, or the folder of FILE; kept "
    "weaknesses need one].",
)
@worker_options
@engine_options(BOTH, CI, default=AUTO)
@click.option("--json", "is_json", is_flag=True, help="Print the result for a script.")
def command(**given: Any) -> None:
    """Find out which faults of a specification break which goal."""
    from mrsfi_runtime.cli.explain import explain_faults

    explain_faults(**given)
