"""Diagnostics of models: a defect of a constraint, and the report of all defects.

A report only collects: checks continue after a defect, and loading asks at the end how many errors
there are. Every message ends with the name of its constraint. docs/constraints.md lists all
constraints with their meaning, in the order in which they are checked. Begin with ``Report.add``.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Any, Protocol

from mrsfi_runtime.errors import Diagnostic, ModelError, Severity, nearest

WARNINGS = (
    "IdWithoutSpaces", "AreaInsideMission", "RobotInsideMission", "RobotStartsClear",
    "RobotHasBattery", "SenderIsMember", "UniqueMessageField", "FieldOfSender",
    "AvoidCollisionMembers", "DeadlineInsideMission", "FigureInsideMission",
    "AsReactionsAssume", "FaultFieldCarried", "WindowInsideMission", "TriggerCanHappen",
)  # fmt: skip
"""Constraints whose defects do not stop loading; those of all others do."""


class Defect(Exception):  # noqa: N818 # models have defects
    """A violation of a named constraint, by an element or file that the caller knows.

    ``finding`` is the end of the message: the finding, the expectation, and the next step.
    """

    def __init__(self, constraint: str, finding: str) -> None:
        super().__init__(finding)
        self.constraint = constraint
        self.finding = finding


class Place(Protocol):
    """Place of an element in a file, and its name in messages."""

    path: Path
    line: int

    @property
    def description(self) -> str:
        """Name of the element, such as ``robots 'r1'``."""


@dataclass(frozen=True, slots=True)
class FileLine:
    """Place of a defect of a whole file."""

    path: Path
    line: int

    @property
    def description(self) -> str:
        """Name of the file."""
        return self.path.name


class Report:
    """Collects the diagnostics of one validation; ``n_errors`` of them stop loading.

    ``n_unsound`` of those prevent sound objects; a repeated reference does not, as the list of
    objects holds it once. ``n_dangling`` are references to missing elements: objects can be made
    without them. ``places`` maps objects to their places, and may grow.
    """

    def __init__(self, places: Mapping[Any, Place] = MappingProxyType({})) -> None:
        self.places = places
        self._found: dict[tuple[object, ...], Diagnostic] = {}
        self.n_errors = 0
        self.n_unsound = 0
        self.n_dangling = 0

    def place(self, element: Any) -> Place:
        """Return the place of an object; a place is returned unchanged."""
        return self.places.get(element, element)

    def add(self, element: Any, constraint: str, finding: str) -> None:
        """Add a defect of an object or a place; ``finding`` follows its name in the message."""
        place = self.place(element)
        key = (place, constraint, finding)
        if key in self._found:  # of a feature that several classes inherit, for example
            return
        is_error, name = constraint not in WARNINGS, place.description
        severity: Severity = "error" if is_error else "warning"
        found = Diagnostic(place.path, place.line, name, constraint, severity, f"{name} {finding}")
        self._found[key] = found
        self.n_errors += is_error
        self.n_unsound += is_error and constraint != "UniqueReference"
        self.n_dangling += constraint == "ResolvedReference"

    def require_no_errors(self) -> None:
        """Raise a ``ModelError`` with all errors so far, one per line, if there are any."""
        if self.n_errors:
            raise self.error()

    def error(self) -> ModelError:
        """Return an error with all errors so far, one per line."""
        return ModelError("\n".join(str(found) for found in self if found.severity == "error"))

    def __iter__(self) -> Iterator[Diagnostic]:
        return iter(self._found.values())


def shown(text: str) -> str:
    """Return a text of a model for use in a message: quoted, on one line, shortened."""
    return repr(text if len(text) <= 60 else text[:60] + "...")


def listed(names: Sequence[str], found: str = "") -> str:
    """Return names for use in a message, with a suggestion of the intended one."""
    return ", ".join(names) + nearest(found, names)
