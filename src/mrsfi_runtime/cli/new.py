"""The command ``mrsfi new``: a project of a team's own."""

from pathlib import Path

import click

from mrsfi.starting import start


def new(name: str, *, source: str | None, published: Path | None) -> None:
    """Make the folder of a new project, and say how to go on."""
    if source is not None and published is not None:
        raise click.UsageError("--from and --import exclude each other")
    folder = start(name, source, published)
    click.echo(f"made       {folder}/, with the mission models/{name}")
    click.echo(f"next       cd {folder} && make evolve")
    click.echo(f"then       mrsfi keep runs/{name}-a-1 --weakness 1 && make regressions")
