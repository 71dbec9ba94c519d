"""Types of messages: definitions, and checks of messages against them.

``parse_message`` and ``parse_parts`` read the text of ``.msg``, ``.srv`` and ``.action`` files
into a ``Definition``. A ``Structure`` is made of a definition and checks messages:
``Structure.convert`` takes a value from JSON and returns the normal form of the message.

A message in normal form is a dictionary with all fields in the order of the definition, each
of the right kind, and no other field. Times are ``secs`` and ``nsecs`` (in ROS 2 ``sec`` and
``nanosec``), arrays of bytes are base64 text, and NaN is a float although JSON writes ``null``.
Every other module relies on this. A value that does not fit is a ``FieldError``, which names
the path to the field.

Begin with ``Structure``. ``settings.TypeTable`` finds definitions by their names.

References
----------
http://wiki.ros.org/msg and http://wiki.ros.org/srv; additions of ROS 2:
https://docs.ros.org/en/jazzy/Concepts/Basic/About-Interfaces.html.
"""

import ast
import base64
import binascii
import re
import struct
import sys
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple, TypeAlias

from mrsfi_bridge.errors import ProtocolError, SettingsError

SCALAR = -1  # array length of a field that is not an array
VARIABLE = 0  # array length of an array of any length

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
"""``struct`` formats of the types that are bytes or numbers; lower case is signed."""

FLOATS = ("float32", "float64")
INTEGERS = tuple(name for name in FORMATS if name not in ("bool", *FLOATS))
TIMES = ("time", "duration")
TEXTS = ("string", "wstring")

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
    """A constant of a message; the value is the text in the definition."""

    name: str
    value: str


@dataclass(frozen=True, slots=True)
class Definition:
    """The fields and constants of a message type."""

    name: str
    fields: tuple[Field, ...]
    constants: tuple[Constant, ...] = ()


def parse_message(
    name: str, lines: list[str], path: Path, ros: int, first_line: int = 1
) -> Definition:
    """Return the definition in the lines of a ``.msg`` file, or of a part of it.

    ``name`` is ``package/Type``, ``ros`` the version of ROS; ``path`` and ``first_line`` are for
    errors. A line that is neither field nor constant, or a duplicate field, is a
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
    text = text.strip()
    if text in {"true", "false"}:
        return text == "true"
    try:
        return ast.literal_eval(text)
    except (ValueError, SyntaxError):
        return text


def _full(type_name: str, package: str) -> str:
    """Return a type's full name; types of the same package have none in definitions."""
    if type_name in _PRIMITIVES or "/" in type_name:
        return type_name
    if type_name == "Header":
        return "std_msgs/Header"
    return f"{package}/{type_name}"


Convert: TypeAlias = Callable[[Any], Any]
"""Returns the normal form of a value, or raises ``FieldError``."""

Default: TypeAlias = Callable[[], Any]  # returns the value of a field that is missing
HEADER = "std_msgs/Header"
_PARTS = {"secs": "sec", "nsecs": "nanosec"}
"""Names in ROS 2 of fields in ROS 1; ROS 2 accepts both."""

BYTE_ARRAYS = ("uint8", "char")  # element types of the arrays that JSON carries as base64 text
_MAX_SHOWN = 60


class FieldError(ProtocolError):
    """A value does not fit the type of its field; ``found`` is the reason without the field."""

    def __init__(self, found: str) -> None:
        super().__init__(found)
        self.found = found
        self.path: list[str] = []

    def __str__(self) -> str:
        place = ".".join(reversed(self.path)).replace(".[", "[")
        return f"field '{place}': {self.found}" if place else self.found


def mismatch(value: Any, expected: str) -> FieldError:
    """Return the error of a value of the wrong kind."""
    shown = repr(value)
    if len(shown) > _MAX_SHOWN:
        shown = f"{shown[:_MAX_SHOWN]}…"
    return FieldError(f"found {shown}, expected {expected}")


class Structure:
    """The checks of one message type; ``find`` returns those of a message type in a field."""

    __slots__ = ("_defaults", "_fields", "_is_moment", "definition", "has_header", "nested", "ros")

    def __init__(
        self, definition: Definition, find: Callable[[str], "Structure"], ros: int = 1
    ) -> None:
        self.definition = definition
        self.ros = ros
        self.nested: dict[str, Structure] = {}
        fields = []
        for field in definition.fields:
            if field.type not in _PRIMITIVES:
                self.nested[field.type] = find(field.type)
            element = _PRIMITIVES.get(field.type) or self.nested[field.type]
            convert, default = element.convert, element.default
            if field.length != SCALAR:
                convert, default = _array(field, convert, default)
            if field.bound:
                convert = _bounded(field, convert)
            if field.default is not None:
                default = partial(convert, field.default)
                default()  # raises an error now if it does not fit
            fields.append((field.name, convert, default))
        moments = ("builtin_interfaces/Time", "builtin_interfaces/Duration")
        self._is_moment = definition.name in moments
        self.has_header = any(
            (field.name, field.type) == ("header", HEADER) for field in definition.fields
        )
        self._defaults = tuple((name, default) for name, _, default in fields)
        if definition.name == HEADER:  # a given header gets the time, a missing one gets 0
            fields = [
                (name, c, partial(c, "now") if name == "stamp" else d) for name, c, d in fields
            ]
        self._fields: tuple[tuple[str, Convert, Default], ...] = tuple(fields)

    @property
    def name(self) -> str:
        """Full name of the type."""
        return self.definition.name

    def default(self) -> dict[str, Any]:
        """Return the message with all fields at their defaults."""
        return {name: default() for name, default in self._defaults}

    def convert(self, value: Any) -> dict[str, Any]:
        """Return the normal form of a message; ``FieldError`` if it is not of this type."""
        if self._is_moment:
            value = _of_ros_2(value)
        if not isinstance(value, dict):
            raise mismatch(value, f"the fields of {self.name}")
        result = {}
        n_found = 0
        name = ""
        try:
            for name, convert, default in self._fields:
                if name in value:
                    result[name] = convert(value[name])
                    n_found += 1
                else:
                    result[name] = default()
        except FieldError as error:
            error.path.append(name)
            raise
        if n_found != len(value):
            raise self._unknown(value)
        return result

    def _unknown(self, value: dict[Any, Any]) -> FieldError:
        known = [name for name, _, _ in self._fields]
        unknown = next(name for name in value if name not in known)
        names = ", ".join(known) or "none"
        return FieldError(f"{self.name} has no field '{str(unknown)[:_MAX_SHOWN]}', only {names}")


def _of_ros_2(moment: Any) -> Any:
    moment = now() if moment == "now" else moment
    if isinstance(moment, dict):
        return {_PARTS.get(name, name): part for name, part in moment.items()}
    return moment


def now() -> dict[str, int]:
    """Return the time of day as ROS has it."""
    secs, nsecs = divmod(time.time_ns(), 1_000_000_000)
    return {"secs": secs, "nsecs": nsecs}


def _integer(type_name: str) -> Convert:
    is_signed, bits = FORMATS[type_name].islower(), 8 * struct.calcsize(f"={FORMATS[type_name]}")
    low = -(1 << bits - 1) if is_signed else 0
    high = (1 << bits - is_signed) - 1

    def convert(value: Any) -> int:
        if type(value) is int and low <= value <= high:
            return value
        raise mismatch(value, f"{type_name}, {low} to {high}")

    return convert


def _number(value: Any) -> float:
    if type(value) is float:
        return value
    if value is None:
        return float("nan")  # NaN travels as null
    if type(value) is int and abs(value) <= sys.float_info.max:
        return float(value)
    raise mismatch(value, "a number")


def _boolean(value: Any) -> bool:
    if type(value) is bool:
        return value
    raise mismatch(value, "true or false")


def _text(value: Any) -> str:
    if type(value) is str:
        if value.isascii():
            return value
        with suppress(UnicodeEncodeError):  # it has half of a surrogate pair
            value.encode()
            return value
    raise mismatch(value, "text")


def _moment(part_type: str) -> Convert:
    part = _integer(part_type)

    def convert(value: Any) -> dict[str, int]:
        if value == "now":
            return now()
        if not isinstance(value, dict) or not value.keys() <= {"secs", "nsecs"}:
            raise mismatch(value, "secs and nsecs")
        return {"secs": part(value.get("secs", 0)), "nsecs": part(value.get("nsecs", 0))}

    return convert


def _array(field: Field, convert: Convert, default: Default) -> tuple[Convert, Default]:
    """Return check and default of an array, from those of its elements."""
    length = field.length
    if field.type in BYTE_ARRAYS:
        empty = base64.b64encode(bytes(length)).decode("ascii")
        return _bytes(length, convert), lambda: empty

    def convert_all(values: Any) -> list[Any]:
        if not isinstance(values, list):
            raise mismatch(values, f"a list of {field.type}")
        _check_length(len(values), length)
        result: list[Any] = []
        try:
            result.extend(map(convert, values))
        except FieldError as error:
            error.path.append(f"[{len(result)}]")
            raise
        return result

    return convert_all, lambda: [default() for _ in range(length)]


def _bytes(length: int, convert: Convert) -> Convert:
    def convert_bytes(value: Any) -> str:
        if isinstance(value, list):
            _check_length(len(value), length)
            return base64.b64encode(bytes(map(convert, value))).decode("ascii")
        if not isinstance(value, str):
            raise mismatch(value, "base64 text or a list of bytes")
        try:
            content = base64.b64decode(value, validate=True)
        except (binascii.Error, ValueError):
            raise mismatch(value, "base64 text") from None
        _check_length(len(content), length)
        return value

    return convert_bytes


def _bounded(field: Field, convert: Convert) -> Convert:
    """Return the check of an array or a text with a bound on its length."""

    def convert_bounded(value: Any) -> Any:
        kind = str if field.length == SCALAR else list
        if isinstance(value, kind) and len(value) > field.bound:
            raise FieldError(f"found a length of {len(value)}, expected at most {field.bound}")
        return convert(value)

    return convert_bounded


def _check_length(found: int, length: int) -> None:
    if length not in (VARIABLE, found):
        raise FieldError(f"found {found} elements, expected {length}")


class _Primitive(NamedTuple):
    convert: Convert
    default: Default


_PRIMITIVES = {
    **{name: _Primitive(_integer(name), int) for name in INTEGERS},
    **dict.fromkeys(FLOATS, _Primitive(_number, float)),
    "bool": _Primitive(_boolean, bool),
    **dict.fromkeys(TEXTS, _Primitive(_text, str)),
    "time": _Primitive(_moment("uint32"), lambda: {"secs": 0, "nsecs": 0}),
    "duration": _Primitive(_moment("int32"), lambda: {"secs": 0, "nsecs": 0}),
}
"""Check and default of each primitive type."""
