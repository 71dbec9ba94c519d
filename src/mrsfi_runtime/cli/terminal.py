"""What rich lays out for terminals: tables on standard output, progress on standard error.

Rich is imported where something is laid out, so that every command may import this module.
"""

import os
import sys
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.console import Console
    from rich.table import Table as Grid

    from mrsfi_runtime.analysis.tables import Table

_WIDTH = 100
"""Columns of a table in a pipe or a file, unless the variable COLUMNS says otherwise."""

_WIDEST = 100_000
"""Columns that hold any table."""

_LEAST = 16
"""Columns that a text which may wrap has at least, if it is as long."""


def progress_console() -> "Console":
    """Return the console of standard error; only on a terminal does it move and have colours."""
    from rich.console import Console

    return Console(file=sys.stderr, highlight=False)


def print_table(table: "Table") -> None:
    """Print a table to standard output, with less where it does not fit; name what is left out.

    No figure, ID or word is ever cut: where even that is too wide, it is printed in as many
    columns as it needs. There are as many as COLUMNS says, or else the terminal, or else 100, so
    that a table is the same in every pipe and log file.
    """
    from rich.text import Text

    console = _console()
    shown = table
    grid, needed = _laid_out(console, table)
    for narrower in table.narrower():
        if needed > console.width:
            shown, (grid, needed) = narrower, _laid_out(console, narrower, is_tight=True)
    console.width = max(console.width, needed)
    console.print(Text(table.title, style="bold"))
    console.print(grid)
    if left_out := [name for name in table.spare if name not in shown.columns]:
        print_words(f"Left out for lack of width: {', '.join(left_out)}")
    console.print()


def print_words(*parts: str | tuple[str, str], indent: int = 0) -> None:
    """Print a text to standard output, wrapped; parts may have a style, such as ``bold red``."""
    from rich.text import Text

    words = Text()
    for part in parts:
        text, style = (part, "") if isinstance(part, str) else part
        words.append("".join(c if c.isprintable() else ascii(c)[1:-1] for c in text), style)
    console = _console()
    for line in words.wrap(console, console.width - indent):
        line.rstrip()
        console.print(Text(" " * indent) + line)


def _console() -> "Console":
    from rich.console import Console

    given = os.environ.get("COLUMNS", "")
    width = int(given) if given.isdecimal() and int(given) > 0 else None
    console = Console(file=sys.stdout, highlight=False, width=width)
    if width is None and not console.is_terminal:
        console.width = _WIDTH
    return console


def _laid_out(console: "Console", table: "Table", *, is_tight: bool = False) -> "tuple[Grid, int]":
    """Return a table in which nothing of a cell becomes markup, and in how many columns it fits.

    If it is tight, numbers and their names go on below where they have spaces.
    """
    from rich import box
    from rich.table import Table as Grid
    from rich.text import Text

    from mrsfi_runtime.analysis.tables import in_words

    padding = (0, 1, 0, 0) if table.is_compact else (0, 1)
    grid = Grid(box=box.SIMPLE_HEAD, show_edge=False, pad_edge=False, padding=padding)
    for name in table.columns:
        is_word = name in table.words and name not in table.texts
        grid.add_column(
            Text(name.replace(" ", "\n") if table.is_compact else name),
            justify="left" if is_word or name in table.texts else "right",
            no_wrap=is_word,
            overflow="fold",
        )
    for row in table.rows:
        grid.add_row(*(Text(in_words(cell)) for cell in row))
    whole = console.options.update(width=_WIDEST)
    for name, column in zip(table.columns, grid.columns, strict=True):
        cells = (column.header, *column.cells)
        sizes = [console.measure(cell, options=whole) for cell in cells]
        longest = max(each.maximum for each in sizes)
        if name in table.texts and name not in table.folded[1]:
            column.min_width = min(_LEAST, longest)
        elif not is_tight or name in (*table.words, *table.texts):
            column.min_width = longest
        else:  # or else rich makes it narrower than its longest number
            column.width = max(each.minimum for each in sizes)
    return grid, console.measure(grid, options=whole).minimum
