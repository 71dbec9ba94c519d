"""Where text goes: results to standard output, progress to standard error."""

import json
from typing import Any

import click


def print_json(value: Any) -> None:
    """Print a value for scripts."""
    click.echo(json.dumps(value, indent=2, allow_nan=False))


def counted(number: int, nouns: str) -> str:
    """Return ``1 robot`` or ``2 robots``."""
    return f"{number} {nouns.removesuffix('s') if number == 1 else nouns}"


def tell(message: str) -> None:
    """Print one line of progress."""
    click.echo(message, err=True)
