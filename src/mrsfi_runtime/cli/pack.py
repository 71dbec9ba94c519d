"""The command ``mrsfi pack``."""

from pathlib import Path

import click

from mrsfi_runtime.cli.console import tell
from mrsfi_runtime.cli.options import file_option


@click.command(name="pack")
@click.argument("run", metavar="CAMPAIGN", type=click.Path(path_type=Path))
@file_option("--out", "The archive [default: CAMPAIGN.zip, in this folder].")
def command(run: Path, out: Path | None) -> None:
    """Pack CAMPAIGN into one file that repeats itself elsewhere.

    It holds models, generated code, settings, every evaluation, and what it was made with; mrsfi
    check FILE flies all of it again, and ends with exit code 7 where anything differs.

    \b
    Examples:
      mrsfi pack runs/uuv_sampling-a-1
      mrsfi pack runs/uuv_sampling-a-1 --out for-the-paper.zip
      mrsfi check for-the-paper.zip
    """
    from mrsfi.campaign import pack

    path = out or Path(f"{run.resolve().name}.zip")
    digest = pack(run, path, tell)
    tell(f"written    {path}")
    click.echo(f"digest     {digest}")
