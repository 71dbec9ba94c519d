"""Binary forms of messages: CBOR with typed arrays, and what ROS nodes send each other.

References
----------
RFC 8949 (CBOR), RFC 8746 (typed arrays), http://wiki.ros.org/roscpp/Overview/MessagesSerializationAndAdaptingTypes.
"""

import base64
import struct
from collections.abc import Iterator
from typing import Any

import cbor2

from mrsfi_bridge.definitions import SCALAR, TIMES, VARIABLE, Field
from mrsfi_bridge.structures import BYTE_ARRAYS, Structure

_FORMATS = {
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
"""Formats of ``struct``; both binary forms are little-endian."""

_TAGS = {
    "uint16": 69,
    "uint32": 70,
    "uint64": 71,
    "byte": 72,
    "int8": 72,
    "int16": 77,
    "int32": 78,
    "int64": 79,
    "float32": 85,
    "float64": 86,
}
"""CBOR tags of typed arrays."""


def cbor(value: Any) -> bytes:
    """Return a value in CBOR."""
    content: bytes = cbor2.dumps(value)
    return content


def tagged(structure: Structure, message: dict[str, Any]) -> dict[str, Any]:
    """Return a message as CBOR is to have it: bytes as bytes, numbers as typed arrays."""
    return {
        field.name: _tagged_field(field, structure, message[field.name])
        for field in structure.definition.fields
    }


def packed(structure: Structure, message: dict[str, Any]) -> bytes:
    """Return a message as ROS nodes send it to each other."""
    return b"".join(_packed_parts(structure, message))


def _tagged_field(field: Field, structure: Structure, value: Any) -> Any:
    nested = structure.nested.get(field.type)
    if field.length == SCALAR:
        return value if nested is None else tagged(nested, value)
    if nested is not None:
        return [tagged(nested, element) for element in value]
    if field.type in BYTE_ARRAYS:
        return base64.b64decode(value)
    if field.type in _TAGS:
        return cbor2.CBORTag(_TAGS[field.type], _packed_numbers(field.type, value))
    return value


def _packed_parts(structure: Structure, message: dict[str, Any]) -> Iterator[bytes]:
    for field in structure.definition.fields:
        value = message[field.name]
        nested = structure.nested.get(field.type)
        if field.length == SCALAR:
            yield _packed_one(field.type, nested, value)
            continue
        content = base64.b64decode(value) if field.type in BYTE_ARRAYS else value
        if field.length == VARIABLE:
            yield struct.pack("<I", len(content))
        if isinstance(content, bytes):
            yield content
        elif field.type in _FORMATS:
            yield _packed_numbers(field.type, content)
        else:
            yield from (_packed_one(field.type, nested, element) for element in content)


def _packed_one(type_name: str, nested: Structure | None, value: Any) -> bytes:
    if nested is not None:
        return packed(nested, value)
    if type_name == "string":
        content: bytes = value.encode()
        return struct.pack("<I", len(content)) + content
    if type_name in TIMES:
        part = "I" if type_name == "time" else "i"
        return struct.pack(f"<{part}{part}", value["secs"], value["nsecs"])
    return _packed_numbers(type_name, [value])


def _packed_numbers(type_name: str, values: list[Any]) -> bytes:
    if type_name == "float32":
        values = [_single(value) for value in values]
    return struct.pack(f"<{len(values)}{_FORMATS[type_name]}", *values)


def _single(value: float) -> float:
    """Return a number that single precision can hold: too large ones become infinite."""
    try:
        struct.pack("<f", value)
    except OverflowError:
        return float("inf") if value > 0 else float("-inf")
    return value
