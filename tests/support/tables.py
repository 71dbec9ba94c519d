"""Tables that tests write as text: a row a line, its cells between bars."""

import re


def rows(table: str) -> list[tuple[str, ...]]:
    r"""Return the cells of each row.

    An indented line goes on with the row before it, ``-`` is an empty cell, ``\n`` a new line.
    """
    return [
        tuple("" if cell == "-" else cell.replace(r"\n", "\n") for cell in _cells(row))
        for row in re.split(r"\n(?! )", table.strip("\n"))
    ]


def _cells(row: str) -> list[str]:
    return re.split(r"\s*\n\s+|\s+\|\s+", row)
