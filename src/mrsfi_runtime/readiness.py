"""What has to hold of generated code before it flies, told without loading it.

It is made for this world's rules, and no region is empty where only the team knows what belongs
there: a check without a body would never find a violation.
"""

import ast
import json
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from mrsfi_runtime.errors import EvaluationError, GenerationError
from mrsfi_runtime.markers import MARKER
from mrsfi_runtime.model.fault_types import SEMANTICS, difference

_OPTIONAL = (".progress",)


def require_semantics(directory: Path) -> None:
    """Refuse code that was generated for other rules of the world than this runtime flies.

    The ``GenerationError`` names both versions, and what to do. A manifest that is missing or is
    none does not say which it was generated for, and is one as well.
    """
    path = directory / "manifest.json"
    if not path.is_file():
        raise GenerationError(f"{path}: no such file; run `mrsfi generate` to make it")
    try:
        found = int(json.loads(path.read_bytes()).get("semantics", 1))  # the first had no number
    except (ValueError, TypeError, AttributeError) as error:
        raise GenerationError(
            f"{path}: is no manifest ({type(error).__name__}: {error}); restore it from version "
            "control, or delete it and run `mrsfi generate`"
        ) from error
    if found != SEMANTICS:
        remedy = "run `mrsfi generate`, then review the diff and your regions"
        raise GenerationError(
            f"{path}: {difference(found)}; {remedy if found < SEMANTICS else 'use a later mrsfi'}"
        )


FILLED, RUNS, COMPILES_ALIKE = "RegionFilled", "RegionRuns", "RegionCompilesAlike"


@dataclass(frozen=True, slots=True)
class RegionFinding:
    """What is wrong with a line: what was found, why it matters and what to write instead.

    ``place`` is the region, function or module that it stands in, such as ``region 'g1.check'``.
    Of the constraints ``RegionFilled`` and ``RegionRuns`` are errors; ``RegionCompilesAlike`` is a
    warning: the line compiles to something else.
    """

    path: Path
    line: int
    place: str
    message: str
    constraint: str = FILLED

    @property
    def is_error(self) -> bool:
        """Whether nothing should fly with it."""
        return self.constraint != COMPILES_ALIKE

    @property
    def words(self) -> str:
        """Where it is, and what."""
        return f"{self.path}:{self.line}: {self.place}: {self.message}"

    def __str__(self) -> str:
        return f"{self.words} [{self.constraint}]"


def region_files(directory: Path) -> list[Path]:
    """Return the generated files that hold regions, if they are there."""
    paths = (directory / name for name in ("collective_intelligence.py", "fault_effects.py"))
    return [path for path in paths if path.is_file()]


def unfilled_regions(directory: Path) -> tuple[RegionFinding, ...]:
    """Return the regions of ``generated/<mission>`` that have to be filled before it can fly.

    A file that is missing, or no Python, has none.
    """
    return tuple(found for path in region_files(directory) for found in _of_file(path))


def require_filled(directory: Path) -> None:
    """Refuse a mission with regions to be filled: an ``EvaluationError`` names each, one a line."""
    found = unfilled_regions(directory)
    if found:
        raise EvaluationError("\n".join(each.words for each in found))


def _of_file(path: Path) -> Iterator[RegionFinding]:
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
            yield RegionFinding(path, number, f"region '{marker['id']}'", message)
