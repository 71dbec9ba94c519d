"""What ``mrsfi generate`` takes."""

from typing import Any

import click

from mrsfi_runtime.cli.commands.missions import generated_option, mission_argument

_HELP = """Generate the middleware of MISSION into generated/NAME/.

What you write between `# protected region … begin` and `… end` is kept, also when robots
are renamed or goals are added. Where generation would lose hand-written code it stops
with exit code 4 and changes nothing. A second run changes nothing. A goal task of your own has
empty regions: they are written, and named with exit code 4 until you fill them.

\b
Examples:
  mrsfi generate uuv_sampling
  mrsfi generate uuv_sampling --diff      what would a changed model change?
  mrsfi generate uuv_sampling --check     for continuous integration
"""


@click.command(name="generate", help=_HELP)
@mission_argument
@generated_option
@click.option("--check", is_flag=True, help="Write nothing; exit code 4 if a file is stale.")
@click.option("--diff", is_flag=True, help="Write nothing; print what would change.")
@click.option("--force", is_flag=True, help="Overwrite edits made outside protected regions.")
def command(**given: Any) -> None:
    """Generate the middleware of MISSION into generated/NAME/."""
    from mrsfi_runtime.cli.generate import generate

    generate(**given)
