"""Names in generated code: every one comes from a model ID, never from a display name."""

import keyword
import re

from mrsfi_runtime.errors import ModelError
from mrsfi_runtime.model.fault_types import plain_name

RESERVED = frozenset({"checks", "reactions", "topics", "commands", "truth"})
"""Identifiers that generated code uses itself, as tables or as a root of topics."""

_ALLOWED = re.compile(r"[A-Za-z0-9_. -]+", re.ASCII)
_IDENTIFIER = re.compile(r"[a-z][a-z0-9_]*", re.ASCII)
_WORD_START = re.compile(r"(?<=[a-z0-9])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z])")


def identifier(text: str) -> str:
    """Return the identifier that a model ID becomes in Python and in ROS topic names.

    It is lower case, ``[a-z][a-z0-9_]*``; runs of ``_``, ``-``, ``.`` and spaces become one
    underscore. An ID that holds other characters than these and ASCII letters and digits, starts
    with no letter, or becomes a Python keyword or a name of generated code, is a ``ModelError``.

    Examples
    --------
    >>> identifier("Scout-1")
    'scout_1'
    """
    name = plain_name(text)
    if not _ALLOWED.fullmatch(text):
        wrong = (
            "cannot be a name in Python; expected ASCII letters, digits, '_', '-', '.' or spaces"
        )
    elif not _IDENTIFIER.fullmatch(name):
        wrong = f"becomes '{name[:40]}', which is no name in Python; expected a letter at the start"
    elif keyword.iskeyword(name) or name in RESERVED:
        wrong = f"becomes '{name}', which Python or generated code uses itself"
    else:
        return name
    shown = ascii(text if len(text) <= 60 else f"{text[:60]}...")
    raise ModelError(f"ID {shown} {wrong}; rename the element")


def constant(text: str) -> str:
    """Return the constant that stands for a model ID: its identifier in upper case."""
    return identifier(text).upper()


def snake_case(class_name: str) -> str:
    """Return a class name in lower case with underscores between its words.

    Examples
    --------
    >>> snake_case("FixedDistanceBetweenRobots")
    'fixed_distance_between_robots'
    """
    return _WORD_START.sub("_", class_name).lower()
