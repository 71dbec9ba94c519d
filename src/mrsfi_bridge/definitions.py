"""ROS message definitions: the text format of ``.msg`` and ``.srv`` files.

References
----------
http://wiki.ros.org/msg and http://wiki.ros.org/srv.
"""

import re
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from mrsfi_bridge.errors import SettingsError

SCALAR = -1
"""Array length of a field that is no array."""

VARIABLE = 0
"""Array length of an array of any length."""

INTEGER_BITS = {
    "byte": (8, True),
    "char": (8, False),
    "int8": (8, True),
    "uint8": (8, False),
    "int16": (16, True),
    "uint16": (16, False),
    "int32": (32, True),
    "uint32": (32, False),
    "int64": (64, True),
    "uint64": (64, False),
}
"""Integer types: number of bits, and whether they have a sign."""

FLOATS = ("float32", "float64")
TIMES = ("time", "duration")
PRIMITIVES = frozenset((*INTEGER_BITS, *FLOATS, *TIMES, "bool", "string"))

_LINE = re.compile(
    r"(?P<type>[A-Za-z]\w*(?:/[A-Za-z]\w*)?)(?:\[(?P<length>\d*)\])?"
    r"\s+(?P<name>[A-Za-z]\w*)\s*(?:=(?P<value>.*))?"
)


@dataclass(frozen=True, slots=True)
class Field:
    """A field of a message, of a primitive type or of the full name of a message type.

    ``length`` is the number of elements of a fixed array, ``VARIABLE`` or ``SCALAR``.
    """

    name: str
    type: str
    length: int = SCALAR


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


def parse_message(name: str, lines: list[str], path: Path, first_line: int = 1) -> Definition:
    """Return the definition that the lines of a ``.msg`` file, or of a part of it, state.

    ``name`` is ``package/Type``; ``path`` and ``first_line`` are for errors. A line that is
    neither field nor constant, or a field that occurs twice, is a ``SettingsError``.
    """
    package = name.partition("/")[0]
    fields: dict[str, Field] = {}
    constants = []
    for number, line in enumerate(lines, first_line):
        if not line.partition("#")[0].strip():
            continue
        found = _parse_line(line, package, f"{path}:{number}")
        if isinstance(found, Constant):
            constants.append(found)
        elif found.name in fields:
            raise SettingsError(f"{path}:{number}: field '{found.name}' occurs twice; rename one")
        else:
            fields[found.name] = found
    return Definition(name, tuple(fields.values()), tuple(constants))


def parse_service(name: str, text: str, path: Path) -> tuple[Definition, Definition]:
    """Return the definitions of request and response that a ``.srv`` text states.

    It is a ``SettingsError`` if the line ``---`` is missing or doubled, or a part is wrong.
    """
    lines = text.splitlines()
    borders = [number for number, line in enumerate(lines) if line.strip() == "---"]
    if len(borders) != 1:
        raise SettingsError(
            f"{path}: {len(borders)} lines '---', expected one between request and response"
        )
    border = borders[0]
    return (
        parse_message(f"{name}Request", lines[:border], path),
        parse_message(f"{name}Response", lines[border + 1 :], path, border + 2),
    )


def _parse_line(line: str, package: str, place: str) -> Field | Constant:
    """Return the field or constant of a line that is not empty."""
    is_text = line.split(maxsplit=1)[0] == "string" and "=" in line.partition("#")[0]
    match = _LINE.fullmatch(line.strip() if is_text else line.partition("#")[0].strip())
    if match is None:
        raise SettingsError(f"{place}: '{line.strip()}', expected 'type name' or 'type NAME=value'")
    type_name, length, name, value = match.group("type", "length", "name", "value")
    if value is not None:
        return Constant(name, value.strip())
    if length is None:
        return Field(name, _full(type_name, package))
    return Field(name, _full(type_name, package), int(length or VARIABLE))


def _full(type_name: str, package: str) -> str:
    """Return a type's full name: types of the same package go without it."""
    if type_name in PRIMITIVES or "/" in type_name:
        return type_name
    if type_name == "Header":
        return "std_msgs/Header"
    return f"{package}/{type_name}"
