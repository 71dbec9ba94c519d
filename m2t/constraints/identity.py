"""Constraints on IDs: their syntax, and the names that they become in Python."""

import re
from collections.abc import Iterator
from typing import TYPE_CHECKING

from m2t.check.structure import ModelTree
from m2t.diagnostics import Defect, Report, shown
from m2t.naming import identifier
from mrsfi_runtime.errors import ModelError

if TYPE_CHECKING:
    from m2t.read.nodes import Node

_NAMELESS = ("IdSyntax", "ReservedId")
"""Constraints on IDs that become no name in Python where they are broken."""

_SYNTAX = re.compile(r"[A-Za-z][A-Za-z0-9_. -]*", re.ASCII)


def check_identities(tree: ModelTree, report: Report, *, become_names: bool) -> None:
    """Check the IDs of one file.

    ``become_names`` says whether they become names in Python, as those of a mission do and those of
    faults do not.
    """
    named: dict[str, Node] = {}
    for text, node in tree.by_id.items():
        defects = [*defects_of_id(text, becomes_name=become_names)]
        for defect in defects:
            report.add(node, defect.constraint, defect.finding)
        if not become_names or any(defect.constraint in _NAMELESS for defect in defects):
            continue
        name = identifier(text)
        first = named.setdefault(name, node)
        if first is not node:
            finding = (
                f"and {first.description} (line {first.line}) both become '{name}' in Python; "
                "rename one"
            )
            report.add(node, "IdClash", finding)


def defects_of_id(text: str, *, becomes_name: bool) -> Iterator[Defect]:
    """Yield what is wrong with an ID, whatever other IDs there are."""
    if not _SYNTAX.fullmatch(text):
        yield Defect(
            "IdSyntax",
            f"has ID {shown(text)}; expected a letter, then letters, digits, '_', '-', '.' or "
            "spaces; rename it",
        )
        return
    if " " in text:
        yield Defect(
            "IdWithoutSpaces",
            f"has the ID {shown(text)} with spaces, which separate IDs in a list of "
            "references; expected none; use '_' or '-'",
        )
    try:
        if becomes_name:
            identifier(text)
    except ModelError:
        yield Defect(
            "ReservedId",
            f"has ID {shown(text)}, a name that Python or generated code uses itself; "
            "expected another; rename it",
        )
