"""ROS definitions: the text format of ``.msg``, ``.srv`` and ``.action`` files.

References
----------
http://wiki.ros.org/msg and http://wiki.ros.org/srv; what ROS 2 adds:
https://docs.ros.org/en/jazzy/Concepts/Basic/About-Interfaces.html.
"""

import ast
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

from mrsfi_bridge.errors import SettingsError

SCALAR = -1
"""Array length of a field that is no array."""

VARIABLE = 0
"""Array length of an array of any length."""

FORMATS = {
    "bool": "?",
    "byte": "b",
    "char": "B",
    "int8": "b",
    "uint8": "B",
    "int16": "h",
    "uint16": "H",
    "int32": "i",
    "uint32": "I",
    "int64": "q",
    "uint64": "Q",
    "float32": "f",
    "float64": "d",
}
"""Formats of ``struct`` of the types that are bytes or numbers; small letters have a sign."""

FLOATS = ("float32", "float64")
INTEGERS = tuple(name for name in FORMATS if name not in ("bool", *FLOATS))
TIMES = ("time", "duration")
TEXTS = ("string", "wstring")
PRIMITIVES = frozenset((*FORMATS, *TIMES, *TEXTS))

_TYPE = r"(?P<type>[A-Za-z]\w*(?:/[A-Za-z]\w*)?)"
_NAME = r"\s+(?P<name>[A-Za-z]\w*)\s*(?:=(?P<value>.*))?"
_LINES = {
    1: re.compile(rf"{_TYPE}(?P<bound>)(?:\[(?P<length>\d*)\])?{_NAME}(?P<default>)"),
    2: re.compile(
        rf"{_TYPE}(?:<=(?P<bound>\d+))?(?:\[(?P<length>(?:<=)?\d*)\])?{_NAME}(?P<default>[^=].*)?"
    ),
}
"""A line of a definition, by version of ROS."""


@dataclass(frozen=True, slots=True)
class Field:
    """A field of a message, of a primitive type or of the full name of a message type.

    ``length`` is the number of elements of a fixed array, ``VARIABLE`` or ``SCALAR``. In ROS 2,
    an array of any length or a text may have a ``bound``, 0 for none, and any field a ``default``.
    """

    name: str
    type: str
    length: int = SCALAR
    bound: int = 0
    default: Any = None


class Constant(NamedTuple):
    """A constant of a message; the value is the text that stands in the definition."""

    name: str
    value: str


@dataclass(frozen=True, slots=True)
class Definition:
    """What a message of one type holds."""

    name: str
    fields: tuple[Field, ...]
    constants: tuple[Constant, ...] = ()


def parse_message(
    name: str, lines: list[str], path: Path, ros: int, first_line: int = 1
) -> Definition:
    """Return the definition that the lines of a ``.msg`` file, or of a part of it, state.

    ``name`` is ``package/Type``, ``ros`` the version of ROS; ``path`` and ``first_line`` are for
    errors. A line that is neither field nor constant, or a field that occurs twice, is a
    ``SettingsError``.
    """
    package = name.partition("/")[0]
    fields: dict[str, Field] = {}
    constants = []
    for number, line in enumerate(lines, first_line):
        if not line.partition("#")[0].strip():
            continue
        found = _parse_line(line, package, f"{path}:{number}", ros)
        if isinstance(found, Constant):
            constants.append(found)
        elif found.name in fields:
            raise SettingsError(f"{path}:{number}: field '{found.name}' occurs twice; rename one")
        else:
            fields[found.name] = found
    return Definition(name, tuple(fields.values()), tuple(constants))


def parse_parts(
    name: str, parts: Sequence[str], text: str, path: Path, ros: int
) -> list[Definition]:
    """Return the definitions of the parts of a ``.srv`` or ``.action`` text, in their order.

    It is a ``SettingsError`` if the lines ``---`` between them are too few or too many, or a part
    is wrong.
    """
    lines = text.splitlines()
    borders = [number for number, line in enumerate(lines) if line.strip() == "---"]
    if len(borders) != len(parts) - 1:
        expected = ("one", "two")[len(parts) - 2]
        raise SettingsError(
            f"{path}: {len(borders)} lines '---', expected {expected} between "
            f"{' and '.join(map(str.lower, parts))}"
        )
    return [
        parse_message(f"{name}{part}", lines[start:end], path, ros, start + 1)
        for part, start, end in zip(
            parts, [0, *(border + 1 for border in borders)], [*borders, len(lines)], strict=True
        )
    ]


def _parse_line(line: str, package: str, place: str, ros: int) -> Field | Constant:
    """Return the field or constant of a line that is not empty."""
    is_text = line.split(maxsplit=1)[0] == "string" and "=" in line.partition("#")[0]
    match = _LINES[ros].fullmatch(line.strip() if is_text else line.partition("#")[0].strip())
    if match is None:
        raise SettingsError(f"{place}: '{line.strip()}', expected 'type name' or 'type NAME=value'")
    type_name, length, name, value = match.group("type", "length", "name", "value")
    if value is not None:
        return Constant(name, value.strip())
    full = _full(type_name, package)
    bound = int(match["bound"] or 0)
    default = _value(match["default"]) if match["default"] else None
    if length is None:
        return Field(name, full, SCALAR, bound, default)
    if length.startswith("<="):
        return Field(name, full, VARIABLE, int(length[2:] or 0), default)
    return Field(name, full, int(length or VARIABLE), 0, default)


def _value(text: str) -> Any:
    """Return a default as it stands in a definition of ROS 2."""
    text = text.strip()
    if text in {"true", "false"}:
        return text == "true"
    try:
        return ast.literal_eval(text)
    except (ValueError, SyntaxError):
        return text


def _full(type_name: str, package: str) -> str:
    """Return a type's full name: types of the same package go without it."""
    if type_name in PRIMITIVES or "/" in type_name:
        return type_name
    if type_name == "Header":
        return "std_msgs/Header"
    return f"{package}/{type_name}"
