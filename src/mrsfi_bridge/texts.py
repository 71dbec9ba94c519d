"""Values as JSON and back: by ``orjson`` where that is installed, which is faster."""

import json
from typing import Any

try:
    import orjson
except ImportError:  # of the extra ``fast``
    orjson = None  # type: ignore[assignment]

_ENCODE = json.JSONEncoder(allow_nan=False, separators=(",", ":"), default=dict).encode


def to_json(value: Any) -> bytes:
    """Return a value as JSON; a number that is none becomes null."""
    if orjson is not None:
        try:
            return orjson.dumps(value, default=dict)
        except TypeError:  # it is a whole number of more than 64 bits, say
            pass
    try:
        return _ENCODE(value).encode()
    except ValueError:
        return _ENCODE(_finite(value)).encode()


def from_json(content: bytes | bytearray | str) -> Any:
    """Return what a JSON text says; a ``ValueError`` or ``RecursionError`` if it is none."""
    if orjson is not None:
        try:
            return orjson.loads(content)
        except ValueError:  # it says NaN, say
            pass
    return json.loads(content)


def _finite(value: Any) -> Any:
    if isinstance(value, float):
        return value if -float("inf") < value < float("inf") else None
    if isinstance(value, dict):
        return {key: _finite(part) for key, part in value.items()}
    if isinstance(value, list):
        return [_finite(part) for part in value]
    return value
