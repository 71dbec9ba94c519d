"""How findings of constraints are worded."""

from typing import Any

from m2t.diagnostics import listed
from m2t.write.xmi import java_double


def identities(elements: Any) -> str:
    """Return the IDs of elements, for messages."""
    return listed([str(element.ID) for element in elements]) or "none"


def number(value: float) -> str:
    """Return a number for messages, spelt as in the file."""
    return str(value) if isinstance(value, int) else java_double(value)
