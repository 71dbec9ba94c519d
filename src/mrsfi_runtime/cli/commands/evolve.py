"""What ``mrsfi evolve`` takes."""

from pathlib import Path
from typing import Any

import click

from mrsfi_runtime.cli.commands.missions import generated_option
from mrsfi_runtime.cli.engines import engine_options, worker_options
from mrsfi_runtime.engine.settings import AUTO
from mrsfi_runtime.model.faults import COSTS
from mrsfi_runtime.record.manifest import BOTH, CI
from mrsfi_runtime.record.settings import ALGORITHM_NAMES, MINIMISING, VIOLATIONS

_HELP = """Evolve fault specifications against MISSION and print what breaks it.

The campaign file says how: algorithm, population, generations, fitness. --case a and
--case b are the files case_a.toml and case_b.toml beside the models; options replace single
values. Everything goes into a new folder, runs/NAME-CASE-N: copies of the models and of the
code it ran on, every evaluation, figures, tables, and the ten worst as XMI.

Then it finds out which faults break which goal, and what is the least that does, with at most as
many flights as the search took, and never more than a thousand; what it prints first is that.
mrsfi weaknesses lists all of it; mrsfi explain says why one specification does what it does.
Somebody else's simulation is only searched on.

\b
Examples:
  mrsfi evolve uuv_sampling
  mrsfi evolve uuv_sampling --case b --ratio g3:g1=2:1
  mrsfi evolve uuv_sampling --seed 7 --generations 5 --out runs/short
  mrsfi evolve uuv_sampling --algorithm random --evaluations 1000
  mrsfi evolve uuv_sampling --algorithm cover --until 0.02
  mrsfi evolve uuv_sampling --algorithm guided --minimise faults --violations true --goals g2
  mrsfi evolve uuv_sampling --case my_campaign.toml --json | jq .best.fitness
  mrsfi evolve --resume runs/uuv_sampling-a-1

Same seed, same result, bit for bit, with any number of workers. A campaign that was ended,
by Ctrl-C, a kill or a loss of power, can be reported and replayed, and goes on with
--resume DIR: nothing that is recorded is evaluated again, and the result is that of one run.
"""


def _goal_ids(_: click.Context, __: click.Parameter, text: str | None) -> list[str] | None:
    return None if text is None else [goal.strip() for goal in text.split(",")]


@click.command(name="evolve", help=_HELP)
@click.pass_context
@click.argument("mission", metavar="[MISSION]", required=False)
@generated_option
@click.option(
    "--case",
    show_default="a",
    metavar="a|b|FILE",
    help="Campaign file: case_NAME.toml beside the models, or any TOML file.",
)
@click.option("--seed", type=int, help="Seed of the search.")
@click.option("--mission-seed", type=int, help="Mission seed: decides the samples.")
@click.option(
    "--algorithm",
    metavar="NAME",
    help=f"How to search: {', '.join(ALGORITHM_NAMES)}, or your own, MODULE:FUNCTION.",
)
@click.option("--generations", type=int, help="Generations after the first.")
@click.option("--population", type=int, help="Individuals of a generation.")
@click.option("--evaluations", type=int, help="Stop after exactly so many evaluations.")
@click.option("--until", type=float, metavar="P", help="Cover until all bounds are at most P.")
@click.option("--faults", type=int, help="Timed faults of an individual; with --minimise at most.")
@click.option("--goals", metavar="G,H,…", callback=_goal_ids, help="Goals to look at.")
@click.option("--violations", metavar="NAME", help=f"What is counted: {', '.join(VIOLATIONS)}.")
@click.option(
    "--minimise",
    metavar="|".join(COSTS),
    help=f"Also seek few of these, by algorithm {' or '.join(MINIMISING)}.",
)
@worker_options
@engine_options(BOTH, CI, default=AUTO)
@click.option(
    "--out",
    type=click.Path(path_type=Path, file_okay=False),
    metavar="DIR",
    help="New folder of the campaign [default: runs/NAME-CASE-N, first free N].",
)
@click.option(
    "--resume",
    type=click.Path(path_type=Path),
    metavar="DIR",
    help="Go on with the campaign in DIR, with its own settings; no MISSION then.",
)
@click.option("--ratio", metavar="G:H=M:N", help="Also pick from the front, such as g3:g1=2:1.")
@click.option("--no-explain", is_flag=True, help="Do not look for the causes of the ten worst.")
@click.option("--json", "is_json", is_flag=True, help="Print the summary for a script.")
def command(ctx: click.Context, /, **given: Any) -> None:
    """Evolve fault specifications against a mission and print the most critical."""
    from mrsfi_runtime.cli.evolve import evolve

    evolve(ctx, **given)
