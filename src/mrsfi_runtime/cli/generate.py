"""The command ``mrsfi generate``."""

from pathlib import Path

import click

from mrsfi.folders import (
    MissionFolders,
    find_mission,
)
from mrsfi.models import generate as generate_code
from mrsfi.models import generation_difference
from mrsfi_runtime.cli.metamodels import tell_of_metamodels
from mrsfi_runtime.errors import GenerationError
from mrsfi_runtime.unfilled import unfilled_regions


def generate(mission: str, generated: Path | None, *, check: bool, diff: bool, force: bool) -> None:
    """Generate the middleware of MISSION into generated/NAME/."""
    folders = find_mission(mission, generated)
    if sum((check, diff, force)) > 1:
        raise click.UsageError("--check, --diff and --force exclude each other")
    tell_of_metamodels()
    if check:
        folders.require_fresh()
        click.echo(f"fresh: {folders.generated}")
    elif diff:
        click.echo(generation_difference(folders.models, folders.generated), nl=False)
    else:
        _write(folders, force=force)


def _write(folders: MissionFolders, *, force: bool) -> None:
    result = generate_code(folders.models, folders.generated, force=force)
    for verb, names in (
        ("written", result.written),
        ("removed", result.removed),
        ("unchanged", result.unchanged),
    ):
        for name in names:
            click.echo(f"{verb:<9}  {folders.generated / name}")
    unfilled = unfilled_regions(folders.generated)
    if unfilled:
        raise GenerationError("\n".join(map(str, unfilled)))
