"""Where text goes: results to standard output, progress to standard error."""

import json
import os
import sys
from collections.abc import Iterable
from io import BufferedWriter, FileIO, TextIOWrapper
from pathlib import Path
from typing import Any

import click

_OUTPUT, _ERRORS = 1, 2


class Sink(FileIO):
    """A stream of this process on which nothing fails; it keeps the first error."""

    error: OSError | None = None

    def write(self, content: Any) -> int:
        """Write, as if there always were room and a reader."""
        try:
            return super().write(content) or 0
        except OSError as error:
            self.error = self.error or error
            return len(content)


def steady_output() -> Sink | None:
    """Let a full disk, a reader that left or a poor encoding end no command midway.

    Returns what standard output became, unless somebody captures that.
    """
    while None in (sys.stdin, sys.stdout, sys.stderr) and os.open(os.devnull, os.O_RDWR) < _ERRORS:
        pass  # or the next file that is opened would be standard output
    for number, name in ((_ERRORS, "stderr"), (_OUTPUT, "stdout")):
        stream = getattr(sys, name)
        output = None
        if stream is getattr(sys, f"__{name}__"):
            output = Sink(number, "w", closefd=False)
            encoding = stream.encoding if stream else "utf-8"
            lines = number == _ERRORS or output.isatty()
            steady = TextIOWrapper(
                BufferedWriter(output), encoding, "backslashreplace", line_buffering=lines
            )
            setattr(sys, name, steady)
    return output


def print_json(value: Any) -> None:
    """Print a value for scripts."""
    click.echo(json.dumps(value, indent=2, allow_nan=False))


def print_changes(respelt: Iterable[Path], difference: Iterable[str]) -> None:
    """Print a unified diff of models, after the files in which more changes than was asked for."""
    for path in respelt:
        click.echo(f"{path}: is not as Eclipse writes it; layout and comments will be lost")
    for line in difference:
        click.echo(line)


def left(seconds: float) -> str:
    """Return how long something may still take: ``left 1:05``."""
    minutes, rest = divmod(round(seconds), 60)
    return f"left {minutes}:{rest:02d}"


def tell(message: str) -> None:
    """Print one line of progress."""
    click.echo(message, err=True)
