"""The lines between which a protected region stands in a generated file."""

import re
from collections.abc import Mapping

MARKER = re.compile(
    r"^[ \t]*# protected region (?P<id>\S+) (?:(?P<state>on|off) begin|end)[ \t]*(?:\n|\Z)",
    re.MULTILINE,
)
"""A marker line with its line end; one that ends a region has no ``state``."""


def lines_in_regions(text: str) -> Mapping[int, str]:
    """Return the region of each line that stands in one, by the number of the line."""
    found = {}
    region = ""
    for number, line in enumerate(text.split("\n"), start=1):
        marker = MARKER.fullmatch(line)
        if marker is not None:
            region = marker["id"] if marker["state"] else ""
        elif region:
            found[number] = region
    return found
