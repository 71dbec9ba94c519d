"""What ``mrsfi import`` takes."""

from pathlib import Path
from typing import Any

import click

_HELP = """Turn FILE, a model published for the paper's prototype, into a mission folder.

FILE has a root Setup of namespace acs_project_setup, which holds a mission and its fault
specifications. Every figure and reference is kept; xmi:id gives way to readable IDs: the
element's own where it can be used, else one from its place, such as g1_area. The result is
validated before anything is written; a model with an error ends with exit code 3, the line of
FILE, and no folder.

\b
Examples:
  mrsfi import ~/downloads/mission.model
  mrsfi import published.xmi --out models/harbour
  mrsfi import published.xmi --out models/harbour --force     replace its models
  mrsfi import published.xmi --json | jq '.notes[] | select(.kind == "inconsistent")'

\b
What it lists, with the line of FILE:
  renamed       an ID that was missing, unusable or taken
  dropped       what the models here do not have: parentID, goal_ID, values of Zero types
  default       what the old format lacks or leaves out: the period of Patrol (a tenth of the
                mission), the deadline of Visit (the last tick) and its tolerance (1.0), the
                tolerance of Track (10.0) and of FixedDistanceBetweenRobots (1.0); an absent
                number is 0, an absent sensor type GPS_POSITION
  inconsistent  what contradicts the rest of FILE, and every warning of `mrsfi validate`

A FILE without fault specifications gets an empty faults.xmi, in which a search needs faults first.
Also written: case_a.toml, and case_b.toml if there are goals for it, unless they exist.
"""


@click.command(name="import", help=_HELP)
@click.argument("file", metavar="FILE", type=click.Path(path_type=Path, exists=True))
@click.option(
    "--out",
    type=click.Path(path_type=Path),
    metavar="DIR",
    help="Mission folder to make [default: models/ and the name of FILE].",
)
@click.option("--force", is_flag=True, help="Replace the models of an existing mission folder.")
@click.option("--json", "is_json", is_flag=True, help="Print the result for a script.")
def command(**given: Any) -> None:
    """Turn a model published for the paper's prototype into a mission folder."""
    from mrsfi_runtime.cli.import_model import import_model

    import_model(**given)
