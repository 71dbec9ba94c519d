"""How constraints report: by object of the model, not by node of the file."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from m2t.diagnostics import Report, listed
from m2t.read.nodes import Node
from m2t.write.xmi import java_double


@dataclass(frozen=True, slots=True)
class Findings:
    """Places findings about objects at their lines."""

    nodes: Mapping[Any, Node]
    report: Report

    def add(self, element: Any, constraint: str, finding: str) -> None:
        """Add a finding that completes a sentence which begins with the element."""
        self.report.add(self.nodes[element], constraint, finding)

    def describe(self, element: Any) -> str:
        """Return the name of an element in messages."""
        return self.nodes[element].description

    def line(self, element: Any) -> int:
        """Return the line of an element."""
        return self.nodes[element].line


def identities(elements: Any) -> str:
    """Return the IDs of elements, for messages."""
    return listed([str(element.ID) for element in elements]) or "none"


def number(value: float) -> str:
    """Return a number for messages, spelt as in the file."""
    return str(value) if isinstance(value, int) else java_double(value)
