"""Tables and text of Markdown in which nothing of a model becomes markup."""

from collections.abc import Iterable, Sequence


def table(header: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """Return a table."""
    return "\n".join(map(table_row, (header, ["---"] * len(header), *rows)))


def table_row(cells: Iterable[object]) -> str:
    """Return a line of a table."""
    return "| " + " | ".join(plain(str(cell)) for cell in cells) + " |"


def plain(text: str) -> str:
    """Return text that cannot break out of its line or cell."""
    return " ".join(text.split()).replace("|", "\\|").replace("<", "&lt;")
