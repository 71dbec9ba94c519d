"""A titled table as a value, and its writers; ``cli/terminal.py`` writes it for terminals."""

import csv
import io
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from html import escape
from typing import Any, TextIO, TypeAlias

from mrsfi_runtime.record.measure import NONE

Cell: TypeAlias = str | int | float | None

_FORMULA = ("=", "+", "-", "@", "\t", "\r")


@dataclass(frozen=True, slots=True)
class Table:
    """Rows under named columns: of words, of texts, which may wrap, and all others of numbers.

    A cell may have several lines, and is ``None`` where there is nothing. A compact table has
    little room between its columns; ``narrow`` is the same for where it does not fit,
    and may have a narrower one itself.
    """

    title: str
    columns: Sequence[str]
    rows: Iterable[Sequence[Cell]]
    words: Sequence[str] = ()
    texts: Sequence[str] = ()
    is_compact: bool = False
    narrow: "Table | None" = None

    @property
    def lines(self) -> Iterator[Sequence[Cell]]:
        """The names of the columns, then the rows."""
        yield self.columns
        yield from self.rows


def every(n: int, most: int) -> int:
    """Return how far apart those are that stay if at most so many of ``n`` may: 1 if all do."""
    return max(1, -(-n // most))


def in_words(cell: Cell) -> str:
    """Return a cell as people read it."""
    if isinstance(cell, float):
        return f"{cell:.2f}" if abs(cell) >= 1 else f"{cell:.3g}"
    return NONE if cell is None else str(cell)


def to_markdown(table: Table) -> str:
    """Return a table without its title; lines of a cell stand behind each other."""
    first, *others = (
        f"| {' | '.join(plain(in_words(cell).replace(chr(10), ' / ')) for cell in line)} |"
        for line in table.lines
    )
    return "\n".join((first, f"| {' | '.join('---' for _ in table.columns)} |", *others))


def to_page(table: Table) -> dict[str, Any]:
    """Return a table as ``page.js`` reads it."""
    return {"title": table.title, "header": list(table.columns), "rows": list(table.rows)}


def to_html(table: Table) -> str:
    """Return a table with its title as HTML in which nothing of a cell becomes markup."""

    def line(tag: str, cells: Sequence[Cell]) -> str:
        return "".join(f"<{tag}>{escape(printable(in_words(cell)))}</{tag}>" for cell in cells)

    rows = "".join(f"<tr>{line('td', row)}</tr>" for row in table.rows)
    caption, head = escape(printable(table.title)), line("th", table.columns)
    return (
        f"<table><caption>{caption}</caption><thead><tr>{head}</tr></thead>"
        f"<tbody>{rows}</tbody></table>"
    )


def as_csv(lines: Iterable[Sequence[Cell]]) -> bytes:
    """Return lines of a table as CSV with line feeds, floats in their shortest exact form."""
    text = io.StringIO()
    write_csv(text, lines)
    return text.getvalue().encode()


def write_csv(file: TextIO, lines: Iterable[Sequence[Cell]]) -> None:
    """Write lines as CSV into a file that leaves line feeds as they are, one after the other."""
    csv.writer(file, lineterminator="\n").writerows(map(_inert, line) for line in lines)


def _inert(cell: Cell) -> Cell:
    """Return a cell that no spreadsheet takes for a formula: a name may begin like one."""
    return f"'{cell}" if isinstance(cell, str) and cell.startswith(_FORMULA) else cell


def plain(text: str) -> str:
    """Return text that cannot break out of its line or cell, nor steer a terminal."""
    return printable(text).replace("|", "\\|").replace("<", "&lt;")


def printable(text: str) -> str:
    """Return text in one line, of characters that are seen."""
    line = " ".join(text.split())
    return "".join(letter if letter.isprintable() else ascii(letter)[1:-1] for letter in line)
