"""Versions of what is installed."""

import click


def installed_version(name: str) -> str:
    """Return the version of a distribution; mrsfi run from its source tree alone has none."""
    from importlib import metadata  # noqa: PLC0415 - takes half as long as `mrsfi --help`

    try:
        return metadata.version(name)
    except metadata.PackageNotFoundError:
        return "not installed"


def print_version(ctx: click.Context, _: click.Parameter, is_wanted: bool) -> None:
    """Print the version of mrsfi and end, if the user asked for it."""
    if is_wanted and not ctx.resilient_parsing:
        click.echo(f"mrsfi, version {installed_version('mrsfi')}")
        ctx.exit()
