"""Regions that are generated empty, because only the team knows what belongs there.

No engine flies a mission that has one: a check without a body would never find a violation.
"""

import ast
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from mrsfi_runtime.errors import EvaluationError
from mrsfi_runtime.markers import MARKER

FILES = ("collective_intelligence.py", "fault_effects.py")
"""Generated files that hold regions."""

_OPTIONAL = (".progress",)


@dataclass(frozen=True, slots=True)
class UnfilledRegion:
    """A region whose function has no body: where it begins, and which it is in words.

    ``message`` says what was found, and what to write.
    """

    path: Path
    line: int
    place: str
    message: str

    def __str__(self) -> str:
        return f"{self.path}:{self.line}: {self.place}: {self.message}"


def unfilled_regions(directory: Path) -> tuple[UnfilledRegion, ...]:
    """Return the regions of ``generated/<mission>`` that have to be filled before it can fly.

    A file that is missing, or no Python, has none.
    """
    paths = (directory / name for name in FILES)
    return tuple(found for path in paths if path.is_file() for found in _of_file(path))


def require_filled(directory: Path) -> None:
    """Refuse a mission with regions to be filled: an ``EvaluationError`` names each, one a line."""
    found = unfilled_regions(directory)
    if found:
        raise EvaluationError("\n".join(map(str, found)))


def _of_file(path: Path) -> Iterator[UnfilledRegion]:
    text = path.read_text(encoding="utf-8", errors="replace")
    try:
        tree = ast.parse(text)
    except (SyntaxError, ValueError):
        return
    lines = text.split("\n")
    for node in tree.body:
        if not isinstance(node, ast.FunctionDef) or len(node.body) > 1:
            continue
        purpose = (ast.get_docstring(node) or "").partition("\n")[0]
        rest = enumerate(lines[node.end_lineno or 0 :], start=(node.end_lineno or 0) + 1)
        number, line = next(((n, line) for n, line in rest if line.strip()), (0, ""))
        marker = MARKER.fullmatch(line)
        if purpose and marker and marker["state"] and not marker["id"].endswith(_OPTIONAL):
            message = f"is empty; expected the body of {node.name}, which is to: {purpose}"
            yield UnfilledRegion(path, number, f"region '{marker['id']}'", message)
