"""Generate the static Python classes from the command line.

Examples
--------
``python -m m2t.classes generated/metamodel`` writes, ``--check`` only tells what is stale.
"""

import sys
from pathlib import Path

import click

from m2t.classes.generator import class_files, stale_files, write_classes
from m2t.metamodels import load_metamodels
from mrsfi_runtime.errors import GenerationError, MrsfiError


@click.command(name="python -m m2t.classes")
@click.argument("folder", type=click.Path(path_type=Path, file_okay=False))
@click.option("--check", is_flag=True, help="Write nothing; exit code 4 if a file is stale.")
def main(folder: Path, *, check: bool) -> None:
    """Generate the static Python classes of both metamodels into FOLDER."""
    try:
        files = class_files(load_metamodels().packages)
        if check and (stale := stale_files(folder, files)):
            raise GenerationError(
                f"{folder}: stale, because the metamodels or templates changed: "
                f"{', '.join(stale)}; run `python -m m2t.classes {folder}` and review the diff"
            )
        if check:
            click.echo(f"fresh: {folder}")
        else:
            written = write_classes(folder, files)
            for name in files:
                click.echo(f"{'written' if name in written else 'unchanged':<9}  {folder / name}")
    except MrsfiError as error:
        click.echo(f"error: {error}", err=True)
        sys.exit(error.exit_code)


if __name__ == "__main__":
    main()
