"""Values as JSON and back: by ``orjson`` where that is installed, which is faster."""

import json
from contextlib import suppress
from json.encoder import c_make_encoder, encode_basestring_ascii  # type: ignore[attr-defined]
from typing import Any

try:
    import orjson
except ImportError:  # of the extra ``fast``
    orjson = None  # type: ignore[assignment, unused-ignore]

_scan = json.JSONDecoder().scan_once  # type: ignore[attr-defined]
"""Reads as ``json.loads`` does, which looks for an encoding and for blanks first."""

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


def _finite(value: Any) -> Any:
    if isinstance(value, float):
        return value if -float("inf") < value < float("inf") else None
    if isinstance(value, dict):
        return {key: _finite(part) for key, part in value.items()}
    if isinstance(value, list):
        return [_finite(part) for part in value]
    return value
