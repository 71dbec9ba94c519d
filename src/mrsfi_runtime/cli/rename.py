"""The command ``mrsfi rename``."""

from collections.abc import Mapping
from pathlib import Path

import click

from mrsfi.folders import find_mission
from mrsfi.renaming import rename as write_renamed
from mrsfi.renaming import renaming
from mrsfi_runtime.cli.console import print_changes, tell
from mrsfi_runtime.cli.metamodels import tell_of_metamodels


def rename(mission: str, names: Mapping[str, str], generated: Path | None, *, diff: bool) -> None:
    """Give elements of a mission other IDs, or print what that would change."""
    tell_of_metamodels()
    renamed = (renaming if diff else write_renamed)(find_mission(mission, generated), names)
    if diff:
        print_changes(renamed.respelt, renamed.difference)
    else:
        for path in renamed.paths:
            click.echo(f"written    {path}")
    for path, line, name in renamed.scripts:
        tell(f"{path}:{line}: names {name}; a script that writes these models has to follow")
