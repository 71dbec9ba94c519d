"""Where text goes: results to standard output, progress to standard error."""

import json
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import click


def print_json(value: Any) -> None:
    """Print a value for scripts."""
    click.echo(json.dumps(value, indent=2, allow_nan=False))


def counted(number: int, nouns: str) -> str:
    """Return ``1 robot`` or ``2 robots``."""
    return f"{number} {nouns.removesuffix('s') if number == 1 else nouns}"


def print_changes(respelt: Iterable[Path], difference: Iterable[str]) -> None:
    """Print a unified diff of models, after the files in which more changes than was asked for."""
    for path in respelt:
        click.echo(f"{path}: is not as Eclipse writes it; layout and comments will be lost")
    for line in difference:
        click.echo(line)


def tell(message: str) -> None:
    """Print one line of progress."""
    click.echo(message, err=True)
