"""The command ``mrsfi rename``."""

from collections.abc import Mapping
from pathlib import Path

import click

from mrsfi_runtime.cli.console import print_changes, tell
from mrsfi_runtime.cli.options import generated_option, mission_argument, tell_of_metamodels


def _names(_: click.Context, __: click.Parameter, words: tuple[str, ...]) -> dict[str, str]:
    names: dict[str, str] = {}
    for word in words:
        old, _equals, new = word.partition("=")
        if not old or not new or old in names:
            message = f"found '{word}'; expected OLD=NEW, such as r1=scout_1, each OLD once"
            raise click.BadParameter(message)
        names[old] = new
    return names


@click.command(name="rename")
@mission_argument
@click.argument("names", metavar="OLD=NEW...", nargs=-1, required=True, callback=_names)
@generated_option
@click.option("--diff", is_flag=True, help="Write nothing; print what would change.")
def command(mission: str, names: Mapping[str, str], generated: Path | None, diff: bool) -> None:
    """Give elements of MISSION other IDs, everywhere at once.

    OLD is the ID of a robot, a goal, a message, a sensor, a fault of the pool or anything else that
    has one. It changes in the models, in every fault specification below their folder, in campaign
    files, in the limits of kept weaknesses, and in generated code: its protected regions follow,
    their markers as well as the names in what is written there. What stands in strings and
    comments, and what a kept weakness tells of the day it was found, stays.

    Display names stay too, and so does the flight: the mission flies to the same digest.

    \b
    Examples:
      mrsfi rename uuv_sampling r1=scout_1 r2=scout_2 --diff
      mrsfi rename uuv_sampling r1=scout_1 r2=scout_2
      mrsfi rename uuv_sampling g1=g2 g2=g1       two IDs change places

    Nothing is written unless everything can be. A script beside the models that names an old ID,
    such as build.py, is not edited: it is told with its line.
    """
    from mrsfi.folders import find_mission, rename, renaming

    tell_of_metamodels()
    renamed = (renaming if diff else rename)(find_mission(mission, generated), names)
    if diff:
        print_changes(renamed.respelt, renamed.difference)
    else:
        for path in renamed.paths:
            click.echo(f"written    {path}")
    for path, line, name in renamed.scripts:
        tell(f"{path}:{line}: names {name}; a script that writes these models has to follow")
