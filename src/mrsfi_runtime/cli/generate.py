"""The command ``mrsfi generate``."""

from pathlib import Path
from typing import TYPE_CHECKING

import click

from mrsfi_runtime.cli.options import generated_option, mission_argument, tell_of_metamodels
from mrsfi_runtime.errors import GenerationError

if TYPE_CHECKING:
    from mrsfi.folders import MissionFolders


@click.command(name="generate")
@mission_argument
@generated_option
@click.option("--check", is_flag=True, help="Write nothing; exit code 4 if a file is stale.")
@click.option("--diff", is_flag=True, help="Write nothing; print what would change.")
@click.option("--force", is_flag=True, help="Overwrite edits made outside protected regions.")
def command(mission: str, generated: Path | None, check: bool, diff: bool, force: bool) -> None:
    """Generate the middleware of MISSION into generated/NAME/.

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
    from mrsfi.folders import diff as difference
    from mrsfi.folders import find_mission

    folders = find_mission(mission, generated)
    if sum((check, diff, force)) > 1:
        raise click.UsageError("--check, --diff and --force exclude each other")
    tell_of_metamodels()
    if check:
        folders.require_fresh()
        click.echo(f"fresh: {folders.generated}")
    elif diff:
        click.echo(difference(folders.models, folders.generated), nl=False)
    else:
        _write(folders, force=force)


def _write(folders: "MissionFolders", *, force: bool) -> None:
    from mrsfi.folders import generate
    from mrsfi_runtime.generated_code import unfilled_regions

    result = generate(folders.models, folders.generated, force=force)
    for verb in ("written", "removed", "unchanged"):
        for name in getattr(result, verb):
            click.echo(f"{verb:<9}  {folders.generated / name}")
    unfilled = unfilled_regions(folders.generated)
    if unfilled:
        raise GenerationError("\n".join(each.words for each in unfilled))
