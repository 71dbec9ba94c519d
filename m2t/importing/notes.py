"""What an import did to a model beyond copying it."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Literal, TypeAlias, get_args

from m2t.diagnostics import Diagnostic, Report

Kind: TypeAlias = Literal["renamed", "dropped", "default", "inconsistent"]
KINDS: tuple[Kind, ...] = get_args(Kind)
"""ID given or changed; left out; filled in; contradicting the rest of the model."""


@dataclass(frozen=True, slots=True)
class Note:
    """One thing that a reader of the imported model should know; ``line`` is of the published file.

    ``element`` is like ``robots 'r1'``, ``feature`` an attribute of it, a child, or ``ID``;
    ``message`` says what was found, and what the import did about it.
    """

    kind: Kind
    line: int
    element: str
    feature: str
    message: str


class Notes:
    """Collects the notes of one import, whose report knows where objects come from."""

    def __init__(self, report: Report) -> None:
        self._report = report
        self._notes: list[Note] = []

    def add(self, kind: Kind, element: Any, feature: str, message: str) -> None:
        """Add a note about an object or a node of the published file."""
        place = self._report.place(element)
        self._notes.append(Note(kind, place.line, place.description, feature, message))

    def add_found(self, found: Diagnostic) -> None:
        """Add what a constraint warns of."""
        note = Note("inconsistent", found.line, found.element, found.constraint, found.message)
        self._notes.append(note)

    def __iter__(self) -> Iterator[Note]:
        return iter(sorted(self._notes, key=lambda note: (KINDS.index(note.kind), note.line)))
