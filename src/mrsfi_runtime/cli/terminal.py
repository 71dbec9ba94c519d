"""What rich lays out for terminals: tables on standard output, progress on standard error."""

import os
import sys

from rich.console import Console
from rich.table import Table
from rich.text import Text

_WIDTH = 100
"""Columns of a table in a pipe or a file, unless the variable COLUMNS says otherwise."""

_WIDEST = 100_000
"""Columns that hold any table."""


def progress_console() -> Console:
    """Return the console of standard error; only on a terminal does it move and have colours."""
    return Console(file=sys.stderr, highlight=False)


def print_table(title: str, *tables: Table) -> None:
    """Print a table to standard output: the first that fits.

    No figure, ID or word is ever cut: where even the last is too wide, it is printed in as many
    columns as it needs. There are as many as COLUMNS says, or else the terminal, or else 100, so
    that a table is the same in every pipe and log file.
    """
    given = os.environ.get("COLUMNS", "")
    width = int(given) if given.isdecimal() and int(given) > 0 else None
    console = Console(file=sys.stdout, highlight=False, width=width)
    if width is None and not console.is_terminal:
        console.width = _WIDTH
    needed = [_needed(console, table) for table in tables]
    table, least = next(
        (pair for pair in zip(tables, needed, strict=True) if pair[1] <= console.width),
        (tables[-1], needed[-1]),
    )
    console.width = max(console.width, least)
    console.print(Text(title, style="bold"))
    console.print(table)
    console.print()


def _needed(console: Console, table: Table) -> int:
    """Return in how many columns a table cuts nothing; let those that must not wrap keep theirs."""
    for column in table.columns:
        if column.no_wrap:
            cells = (column.header, *column.cells)
            column.min_width = max(console.measure(cell).maximum for cell in cells)
    return console.measure(table, options=console.options.update(width=_WIDEST)).minimum
