"""The constraints as docs/constraints.md lists them."""

import re
from pathlib import Path
from typing import NamedTuple

PAGE = Path(__file__).parents[2] / "docs" / "constraints.md"


class Listed(NamedTuple):
    """A row of the table: ``evl`` is the file that states it for Epsilon, or ``none``."""

    severity: str
    meaning: str
    fix: str
    evl: str


_TEXT = PAGE.read_text(encoding="utf-8")

LISTED = {
    name: Listed(*(each.strip(" `") for each in cells.split("|")))
    for name, cells in re.findall(r"(?m)^\| `(\w+)` \|(.*)\|$", _TEXT)
}
"""All rows by name, in their order."""

REASONS = {
    reason: tuple(re.findall(r"\w+", names))
    for reason, names in re.findall(r"(?m)^- ([^`\n]+):\n  (`.*)\.$", _TEXT)
}
"""Why EVL does not state some, and which."""
