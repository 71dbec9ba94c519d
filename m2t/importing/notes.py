"""What an import did to a model beyond copying it."""

from dataclasses import dataclass
from typing import Any, Literal, TypeAlias, get_args

from m2t.diagnostics import Report

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


class Notes(list[Note]):
    """The notes of one import, whose report knows where objects come from."""

    def __init__(self, report: Report) -> None:
        super().__init__()
        self._report = report

    def add(self, kind: Kind, element: Any, feature: str, message: str) -> None:
        """Add a note about an object or a node of the published file."""
        place = self._report.place(element)
        self.append(Note(kind, place.line, place.description, feature, message))
