"""Where text goes: results to standard output, progress to standard error."""

import json
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, TextIO

import click

from mrsfi_runtime.errors import UsageError


def print_json(value: Any) -> None:
    """Print a value for scripts."""
    click.echo(json.dumps(value, indent=2, allow_nan=False))


def counted(number: int, nouns: str) -> str:
    """Return ``1 robot`` or ``2 robots``."""
    return f"{number} {nouns.removesuffix('s') if number == 1 else nouns}"


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
        raise UsageError(
            f"{path}: cannot be written: {error.strerror}; name another file"
        ) from error
