"""How commands name a mission."""

from pathlib import Path

import click

mission_argument = click.argument("mission", metavar="MISSION")
"""Gives a command the argument MISSION."""

generated_option = click.option(
    "--generated",
    type=click.Path(path_type=Path, file_okay=False),
    metavar="DIR",
    help="Folder of the generated code [default: generated/NAME beside models/].",
)
"""Gives a command the option --generated."""
