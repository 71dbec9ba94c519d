"""Constraints on IDs: their syntax, and the names that they become in Python."""

import re
from collections.abc import Mapping

from m2t.check.structure import ModelTree
from m2t.diagnostics import Report, shown
from m2t.naming import clashes, identifier
from m2t.read.nodes import Node
from mrsfi_runtime.errors import ModelError

_SYNTAX = re.compile(r"[A-Za-z][A-Za-z0-9_. -]*", re.ASCII)


def check_identities(tree: ModelTree, report: Report, *, become_names: bool) -> None:
    """Check the IDs of one file.

    Parameters
    ----------
    tree
        The model.
    report
        Takes the diagnostics.
    become_names
        Whether the IDs become names in Python, as those of a mission do and those of faults
        do not.
    """
    sound = {text: node for text, node in tree.by_id.items() if _has_syntax(text, node, report)}
    if become_names:
        free = {text: node for text, node in sound.items() if _is_free(text, node, report)}
        _check_clashes(free, report)


def _has_syntax(text: str, node: Node, report: Report) -> bool:
    if not _SYNTAX.fullmatch(text):
        report.add(
            node,
            "IdSyntax",
            f"has ID {shown(text)}; expected a letter, then letters, digits, '_', '-', '.' or "
            "spaces; rename it",
        )
        return False
    if " " in text:
        report.add(
            node,
            "IdWithoutSpaces",
            f"has the ID {shown(text)} with spaces, which separate IDs in a list of references; "
            "expected none; use '_' or '-'",
        )
    return True


def _is_free(text: str, node: Node, report: Report) -> bool:
    try:
        identifier(text)
    except ModelError:
        report.add(
            node,
            "ReservedId",
            f"has ID {shown(text)}, a name that Python or generated code uses itself; "
            "expected another; rename it",
        )
        return False
    return True


def _check_clashes(nodes: Mapping[str, Node], report: Report) -> None:
    for name, (first_spelling, *spellings) in clashes(nodes):
        first = nodes[first_spelling]
        for spelling in spellings:
            report.add(
                nodes[spelling],
                "IdClash",
                f"and {first.description} (line {first.line}) both become '{name}' in Python; "
                "rename one",
            )
