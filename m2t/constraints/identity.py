"""Constraints on IDs: their syntax, and the names that they become in Python."""

import re
from collections.abc import Iterable
from typing import Any

from m2t.constraints.findings import Findings
from m2t.diagnostics import shown
from m2t.naming import clashes, identifier
from m2t.structure import ModelTree
from mrsfi_runtime.errors import ModelError

_SYNTAX = re.compile(r"[A-Za-z][A-Za-z0-9_. -]*", re.ASCII)


def check_identities(tree: ModelTree, findings: Findings, *, become_names: bool) -> None:
    """Check the IDs of one file.

    Parameters
    ----------
    tree
        The model.
    findings
        Takes the diagnostics.
    become_names
        Whether the IDs become names in Python, as those of a mission do and those of faults
        do not.
    """
    sound = [
        element for text, element in tree.by_id.items() if _has_syntax(text, element, findings)
    ]
    if not become_names:
        return
    named = [element for element in sound if _is_free(element, findings)]
    _check_clashes(named, findings)


def _has_syntax(text: str, element: Any, findings: Findings) -> bool:
    if not _SYNTAX.fullmatch(text):
        findings.add(
            element,
            "IdSyntax",
            f"has ID {shown(text)}; expected a letter, then letters, digits, '_', '-', '.' or "
            "spaces; rename it",
        )
        return False
    if " " in text:
        findings.add(
            element,
            "IdWithoutSpaces",
            f"has the ID {shown(text)} with spaces, which separate IDs in a list of references; "
            "expected none; use '_' or '-'",
        )
    return True


def _is_free(element: Any, findings: Findings) -> bool:
    try:
        identifier(element.ID)
    except ModelError:
        findings.add(
            element,
            "ReservedId",
            f"has ID {shown(element.ID)}, a name that Python or generated code uses itself; "
            "expected another; rename it",
        )
        return False
    return True


def _check_clashes(elements: Iterable[Any], findings: Findings) -> None:
    by_id = {element.ID: element for element in elements}
    for name, spellings in clashes(by_id):
        first = by_id[spellings[0]]
        for spelling in spellings[1:]:
            element = by_id[spelling]
            findings.add(
                element,
                "IdClash",
                f"and {findings.describe(first)} (line {findings.line(first)}) both become "
                f"'{name}' in Python; rename one",
            )
