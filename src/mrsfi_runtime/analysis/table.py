"""A titled table as a value, and its writers; ``cli/terminal.py`` writes it for terminals."""

import csv
import io
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from html import escape
from itertools import zip_longest
from typing import Any, TextIO, TypeAlias

from mrsfi_runtime.record.store import NONE

Cell: TypeAlias = str | int | float | None

_FORMULA = ("=", "+", "-", "@", "\t", "\r")


@dataclass(frozen=True, slots=True)
class Table:
    """Rows under named columns: of words, of texts, which may wrap, and all others of numbers.

    A cell may have several lines, and is ``None`` where there is nothing. A compact table has
    little room between its columns. On a terminal that is too narrow, ``spare`` columns are left
    out first; then those that are ``folded``, which stand side by side, become one of that name.
    """

    title: str
    columns: Sequence[str]
    rows: Iterable[Sequence[Cell]]
    words: Sequence[str] = ()
    texts: Sequence[str] = ()
    is_compact: bool = False
    spare: Sequence[str] = ()
    folded: tuple[str, Sequence[str]] = ("", ())

    @property
    def lines(self) -> Iterator[Sequence[Cell]]:
        """The names of the columns, then the rows."""
        yield self.columns
        yield from self.rows

    def narrower(self) -> "Iterator[Table]":
        """Yield the table as it is, then with less: without spare columns, with folded ones."""
        yield self
        table = self
        if self.spare:
            kept = [k for k, name in enumerate(self.columns) if name not in self.spare]
            shorter = [[row[k] for k in kept] for row in self.rows]
            table = replace(self, columns=[self.columns[k] for k in kept], rows=shorter)
            yield table
        name, folded = self.folded
        if folded:
            first = table.columns.index(folded[0])
            last = first + len(folded)
            columns = (*table.columns[:first], name, *table.columns[last:])
            rows = [
                (*row[:first], self._in_one(row[first:last]), *row[last:]) for row in table.rows
            ]
            texts = (*self.texts, name)
            yield replace(table, columns=columns, rows=rows, texts=texts, folded=("", ()))

    def _in_one(self, cells: Sequence[Cell]) -> str:
        """Return folded cells as one: numbers behind their names, each text on its own line."""

        def part(name: str, cell: str) -> str:
            if cell in {"", NONE}:
                return ""
            if name in self.texts:
                return f"\n{cell}"
            return f" {cell}" if name in self.words else f" {name}:{cell}"

        by_line = zip_longest(*(in_words(cell).split("\n") for cell in cells), fillvalue="")
        return "\n".join("".join(map(part, self.folded[1], line))[1:] for line in by_line)


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
