"""Where text goes: results to standard output, progress to standard error."""

import json
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, TextIO

import click
from rich.console import Console
from rich.table import Table
from rich.text import Text

from mrsfi_runtime.errors import UsageError

_WIDTH = 100
"""Columns of a table that is not printed on a terminal."""


def progress_console() -> Console:
    """Return the console of standard error; only on a terminal does it move and have colours."""
    return Console(file=sys.stderr, highlight=False)


def print_table(title: str, table: Table) -> None:
    """Print a table to standard output, with the same width in every pipe and log file."""
    console = Console(file=sys.stdout, highlight=False)
    if not console.is_terminal:
        console = Console(file=sys.stdout, highlight=False, width=_WIDTH)
    console.print(Text(title, style="bold"))
    console.print(table)
    console.print()


def print_json(value: Any) -> None:
    """Print a value for scripts."""
    click.echo(json.dumps(value, indent=2, allow_nan=False))


def tell(message: str) -> None:
    """Print one line of progress."""
    click.echo(message, err=True)


@contextmanager
def written_file(path: Path) -> Iterator[TextIO]:
    """Open a file that the user asked for.

    Raises
    ------
    UsageError
        If it cannot be written.
    """
    try:
        with path.open("w", encoding="utf-8", newline="\n") as file:
            yield file
    except OSError as error:
        message = f"{path}: cannot be written: {error.strerror}; name another file"
        raise UsageError(message) from error
