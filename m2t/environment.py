"""The Jinja environment and its filters: the only way for a model's text into code.

``literal`` turns a value into a Python literal, ``expression`` a tree of calls into a
formatted expression, ``remark`` free text into something that is safe after a ``#``,
``docstring`` free text into a docstring. No other way is open to model text that is not a checked
identifier.
"""

import math
import re
from dataclasses import dataclass
from functools import cache
from typing import TypeAlias

from jinja2 import Environment, PackageLoader, StrictUndefined

LINE_LENGTH = 100
_REMARK_LENGTH = 40
_EXCHANGED_QUOTES = str.maketrans("'\"", "\"'")
"""Python prefers single quotes, formatters prefer double ones."""

_PLAIN_REMARK = re.compile(r"(?!noqa|nosec)[A-Za-z0-9_.-]{1,40}", re.ASCII | re.IGNORECASE)

Scalar: TypeAlias = str | int | float | bool | None


@dataclass(frozen=True, slots=True)
class Call:
    """A call with keyword arguments; those without a name are positional.

    ``is_flat`` asks for one line where it fits; otherwise there is one argument a line, so
    that a changed value changes one line.
    """

    function: str
    arguments: tuple[tuple[str, "Expression"], ...] = ()
    is_flat: bool = False


@dataclass(frozen=True, slots=True)
class Table:
    """A dictionary literal with text keys."""

    entries: tuple[tuple[str, "Expression"], ...]


@dataclass(frozen=True, slots=True)
class Name:
    """A name that code knows, never a text of a model; what precedes a dot is imported."""

    text: str


Expression: TypeAlias = Scalar | Call | Table | Name | tuple["Expression", ...]


def literal(value: Scalar | tuple[object, ...]) -> str:
    """Return the Python literal of a scalar or tuple, in ASCII and as a formatter would write it.

    A number that is not finite is a ``ValueError``, a value of another type a ``TypeError``.
    """
    if value is None or isinstance(value, bool):
        return repr(value)
    if isinstance(value, str):
        if value.count('"') > value.count("'"):
            return ascii(value)
        return ascii(value.translate(_EXCHANGED_QUOTES)).translate(_EXCHANGED_QUOTES)
    if isinstance(value, int):
        return int.__repr__(value)
    if isinstance(value, float):
        if not math.isfinite(value):
            raise ValueError(f"no literal for the number {value!r}; expected a finite one")
        return float.__repr__(value).replace("e+", "e")
    if isinstance(value, tuple):
        entries = ", ".join(literal(entry) for entry in value)  # type: ignore[arg-type]
        return f"({entries},)" if len(value) == 1 else f"({entries})"
    raise TypeError(f"no literal for a value of type {type(value).__name__}")


def remark(text: str) -> str:
    """Return free text as it may stand in a comment: one line of ASCII, 40 characters.

    A plain word stays as it is; everything else is quoted, escaped and cut.
    """
    if _PLAIN_REMARK.fullmatch(text):
        return text
    return ascii(text[:_REMARK_LENGTH])[:_REMARK_LENGTH].replace("#", "?")


def docstring(text: str) -> str:
    """Return free text as a docstring, in ASCII."""
    escaped = text.encode("unicode_escape").decode("ascii").replace('"', '\\"')
    return f'"""{escaped}"""'


def expression(value: Expression, indent: int = 0, used: int = 0) -> str:
    """Return a Python expression, laid out as a formatter would leave it.

    ``indent`` is the indentation of the line on which it begins, of which what stands around it
    takes ``used`` columns.
    """
    flat = _flat(value)
    opening, entries, closing = _parts(value)
    if flat is not None and (not entries or indent + used + len(flat) <= LINE_LENGTH):
        return flat
    inner = indent + 4
    lines = [
        f"{' ' * inner}{prefix}{expression(entry, inner, len(prefix) + 1)},\n"
        for prefix, entry in entries
    ]
    return f"{opening}\n{''.join(lines)}{' ' * indent}{closing}"


def _parts(value: Expression) -> tuple[str, list[tuple[str, Expression]], str]:
    """Return how an expression begins, its entries with what stands before each, and its end."""
    if isinstance(value, Call):
        arguments = [(f"{name}=" if name else "", entry) for name, entry in value.arguments]
        return f"{value.function}(", arguments, ")"
    if isinstance(value, Table):
        return "{", [(f"{literal(name)}: ", entry) for name, entry in value.entries], "}"
    return "(", [("", entry) for entry in value] if isinstance(value, tuple) else [], ")"


def _flat(value: Expression) -> str | None:
    """Return an expression on one line, or ``None`` where one entry a line is wanted.

    A tuple of one entry has no choice: formatters join it whenever it fits.
    """
    if isinstance(value, Name):
        return value.text
    if not isinstance(value, Call | Table | tuple):
        return literal(value)
    if isinstance(value, tuple):
        is_short = len(value) < 2 or not any(
            isinstance(each, Call | Table | tuple) for each in value
        )
    else:
        is_short = isinstance(value, Table) or value.is_flat or not value.arguments
    opening, entries, closing = _parts(value)
    flat = [(prefix, _flat(entry)) for prefix, entry in entries] if is_short else []
    if not is_short or any(text is None for _, text in flat):
        return None
    joined = ", ".join(f"{prefix}{text}" for prefix, text in flat)
    comma = "," if isinstance(value, tuple) and len(flat) == 1 else ""
    return f"{opening}{joined}{comma}{closing}"


@cache
def template_environment(folder: str = "templates") -> Environment:
    """Return the environment that renders a folder of ``m2t``; an undefined name is an error."""
    environment = Environment(
        loader=PackageLoader("m2t", folder),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    filters = (literal, expression, remark, docstring)
    environment.filters |= {each.__name__: each for each in filters}
    return environment
