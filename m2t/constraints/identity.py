"""Constraints on IDs: their syntax, and the names that they become in Python."""

import re

from m2t.check.structure import ModelTree
from m2t.diagnostics import Report, shown
from m2t.naming import identifier
from m2t.read.nodes import Node
from mrsfi_runtime.errors import ModelError

_SYNTAX = re.compile(r"[A-Za-z][A-Za-z0-9_. -]*", re.ASCII)


def check_identities(tree: ModelTree, report: Report, *, become_names: bool) -> None:
    """Check the IDs of one file.

    ``become_names`` says whether they become names in Python, as those of a mission do and those of
    faults do not.
    """
    named: dict[str, Node] = {}
    for text, node in tree.by_id.items():
        if not _SYNTAX.fullmatch(text):
            report.add(
                node,
                "IdSyntax",
                f"has ID {shown(text)}; expected a letter, then letters, digits, '_', '-', '.' or "
                "spaces; rename it",
            )
            continue
        if " " in text:
            report.add(
                node,
                "IdWithoutSpaces",
                f"has the ID {shown(text)} with spaces, which separate IDs in a list of "
                "references; expected none; use '_' or '-'",
            )
        if become_names:
            _check_name(text, node, named, report)


def _check_name(text: str, node: Node, named: dict[str, Node], report: Report) -> None:
    """Check the name that an ID becomes; ``named`` has the first element of each name so far."""
    try:
        name = identifier(text)
    except ModelError:
        report.add(
            node,
            "ReservedId",
            f"has ID {shown(text)}, a name that Python or generated code uses itself; "
            "expected another; rename it",
        )
        return
    first = named.setdefault(name, node)
    if first is not node:
        report.add(
            node,
            "IdClash",
            f"and {first.description} (line {first.line}) both become '{name}' in Python; "
            "rename one",
        )
