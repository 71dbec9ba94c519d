"""What ``mrsfi simulate`` takes."""

from pathlib import Path
from typing import Any

import click

from mrsfi_runtime.cli.commands.missions import generated_option, mission_argument
from mrsfi_runtime.cli.engines import SIMULATION, engine_options, recording_options
from mrsfi_runtime.record.manifest import BOTH, CI

_HELP = """Fly MISSION once and print what happened to each goal.

Without --faults it flies without faults. A fault specification is XMI: one that search found
(runs/NAME/critical/01.xmi), or one written by hand: a copy of the pool whose faults have
start and finish.

\b
Examples:
  mrsfi simulate uuv_sampling
  mrsfi simulate uuv_sampling --seed 7 --log flight.log --trace flight.csv
  mrsfi simulate uuv_sampling --faults runs/uuv_sampling-a-1/critical/01.xmi
  mrsfi simulate uuv_sampling --engine rosbridge

\b
On a server of yours, simulation and collective intelligence apart:
  mrsfi bridge --port 9090
  mrsfi simulate uuv_sampling --engine rosbridge --url ws://127.0.0.1:9090 --side simulation
  mrsfi simulate uuv_sampling --engine rosbridge --url ws://127.0.0.1:9090 --side ci

A violation counts once per goal and tick: believed by the collective intelligence, true in
the simulation, phantom (believed, not true), masked (true, not believed). A goal is missed from
the tick on at which it is certain, from the truth alone, that its purpose is not met; – if it was
met.
"""


@click.command(name="simulate", help=_HELP)
@mission_argument
@generated_option
@click.option("--no-faults", is_flag=True, help="Fly without faults, as without this option.")
@click.option(
    "--faults",
    type=click.Path(path_type=Path, dir_okay=False),
    metavar="FILE",
    help="Fly under this fault specification.",
)
@click.option("--seed", type=click.IntRange(0), default=1, show_default=True, help="Mission seed.")
@recording_options
@engine_options(BOTH, CI, SIMULATION)
@click.option("--json", "is_json", is_flag=True, help="Print the result for a script.")
def command(**given: Any) -> None:
    """Fly a mission once and print what happened to each goal."""
    from mrsfi_runtime.cli.simulate import simulate

    simulate(**given)
