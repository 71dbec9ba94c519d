"""Values as JSON and back: by ``orjson`` where that is installed, which is faster.

What is written in C lets no other thread run meanwhile. Of what is large, ``to_large_json`` and
``LARGE_DECODER`` do a part at a time.
"""

import json
import re
from collections.abc import Callable, Iterator
from contextlib import suppress
from json.decoder import JSONArray, JSONObject  # type: ignore[attr-defined]
from json.encoder import c_make_encoder, encode_basestring_ascii  # type: ignore[attr-defined]
from json.scanner import py_make_scanner  # type: ignore[attr-defined]
from typing import Any

try:
    import orjson
except ImportError:  # of the extra ``fast``
    orjson = None  # type: ignore[assignment, unused-ignore]

_PART = 1 << 14
"""Numbers of a list that are written in one go."""

_PART_LETTERS = 1 << 17
_scan = json.JSONDecoder().scan_once  # type: ignore[attr-defined]
"""Reads as ``json.loads`` does, which looks for an encoding and for blanks first."""

_NUMBERS = re.compile(r"[-+0-9.eE,\s]*")
if c_make_encoder is None:
    _encode = json.JSONEncoder(allow_nan=False, separators=(",", ":"), default=dict).encode
else:  # the same, which makes what encodes anew for each value
    _PARTS = c_make_encoder(
        None, dict, encode_basestring_ascii, None, ":", ",", False, False, False
    )

    def _encode(o: Any) -> str:
        return "".join(_PARTS(o, 0))


def to_json(value: Any) -> bytes:
    """Return a value as JSON; a number that is none becomes null."""
    if orjson is not None:
        with suppress(TypeError):  # it is a whole number of more than 64 bits, say
            content: bytes = orjson.dumps(value, default=dict)
            return content
    try:
        return _encode(value).encode()
    except ValueError:
        return _encode(_finite(value)).encode()


def from_json(content: bytes | bytearray | str) -> Any:
    """Return what a JSON text says; a ``ValueError`` or ``RecursionError`` if it is none."""
    if orjson is not None:
        with suppress(ValueError):  # it says NaN, say
            return orjson.loads(content)
    text = content if isinstance(content, str) else content.decode()
    with suppress(StopIteration):
        value, end = _scan(text, 0)
        if end == len(text):
            return value
    return json.loads(text)


def to_large_json(value: Any) -> bytes:
    """Return the same as ``to_json``."""
    return b"".join(_pieces(value))


def _pieces(value: Any) -> Iterator[bytes]:
    if isinstance(value, dict):
        for number, (key, part) in enumerate(value.items()):
            yield b"%s%s:" % (b"," if number else b"{", to_json(key))
            yield from _pieces(part)
        yield b"}" if value else b"{}"
    elif isinstance(value, list) and len(value) > _PART:
        for start in range(0, len(value), _PART):
            yield b"," if start else b"["
            yield to_json(value[start : start + _PART])[1:-1]
        yield b"]"
    else:
        yield to_json(value)


def _array(place: tuple[str, int], scan: Callable[..., Any]) -> tuple[list[Any], int]:
    """Return the list that begins before a place in a text, and where it ends."""
    text, start = place
    end = text.find("]", start)
    if end - start < _PART_LETTERS or not _NUMBERS.fullmatch(text, start, end):
        found: tuple[list[Any], int] = JSONArray(place, scan)
        return found
    values: list[Any] = []
    while start <= end:
        cut = text.find(",", min(start + _PART_LETTERS, end), end)
        cut = end if cut < 0 else cut
        part = json.loads(f"[{text[start:cut]}]")
        if not part:
            raise json.JSONDecodeError("Expecting value", text, start)
        values += part
        start = cut + 1
    return values, end + 1


class _LargeDecoder(json.JSONDecoder):
    """Reads as Python does, but long lists of numbers part by part in C."""

    def __init__(self) -> None:
        super().__init__()
        self.parse_object, self.parse_array = JSONObject, _array
        self.scan_once = py_make_scanner(self)


LARGE_DECODER = _LargeDecoder()
"""Reads JSON texts that are large."""


def _finite(value: Any) -> Any:
    if isinstance(value, float):
        return value if -float("inf") < value < float("inf") else None
    if isinstance(value, dict):
        return {key: _finite(part) for key, part in value.items()}
    if isinstance(value, list):
        return [_finite(part) for part in value]
    return value
