"""Tables that tests write as text: a row a line, its cells between bars."""

import re


def rows(table: str) -> list[tuple[str, ...]]:
    """Return the cells of each row; an indented line goes on with its row, ``-`` is empty."""
    return [
        tuple("" if cell == "-" else cell for cell in re.split(r"\s*\n\s+|\s+\|\s+", row))
        for row in re.split(r"\n(?! )", table.strip("\n"))
    ]
