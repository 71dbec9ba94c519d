"""Messages on their way to clients: JSON, PNG, CBOR with typed arrays, whole or in fragments.

References
----------
https://github.com/RobotWebTools/rosbridge_suite/blob/ros1/ROSBRIDGE_PROTOCOL.md, sections 3.1
and 3.2. RFC 8949 (CBOR), RFC 8746 (typed arrays); what ROS nodes send each other:
http://wiki.ros.org/roscpp/Overview/MessagesSerializationAndAdaptingTypes, and CDR of the Object
Management Group.
"""

import base64
import math
import struct
import zlib
from collections.abc import Sequence
from itertools import count
from typing import Any, NamedTuple, TypeAlias

import cbor2
from websockets.frames import OP_BINARY, OP_TEXT, Opcode

from mrsfi_bridge.structures import (
    BYTE_ARRAYS,
    FORMATS,
    SCALAR,
    TEXTS,
    TIMES,
    VARIABLE,
    Field,
    Structure,
    now,
)
from mrsfi_bridge.texts import to_json

_MAX_FRAGMENTS = 4096
_MAX_KEPT = 8
"""Encodings of one message that are kept."""

_CDR = b"\0\1\0\0"
"""Says that little-endian CDR follows."""

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

_fragment_ids = count()


COMPRESSIONS = ("none", "png", "cbor", "cbor-raw")


class Encoding(NamedTuple):
    """How a client wants what it is sent; the compression is one of ``COMPRESSIONS``.

    Texts of more than ``fragment_size`` letters are cut into fragments, but into no more than
    4,096. Binary frames stay whole.
    """

    compression: str = "none"
    fragment_size: int | None = None


PLAIN = Encoding()

Form: TypeAlias = tuple[str, Encoding]
"""The topic of a message, as a client spells it, and how that wants it."""


class Outgoing:
    """A published message in its normal form, which nobody may change.

    It is encoded once however many clients receive it.
    """

    __slots__ = ("_frames", "message", "structure")

    def __init__(self, structure: Structure, message: dict[str, Any]) -> None:
        self.structure = structure
        self.message = message
        self._frames: dict[Form, bytes] = {}

    def frames(self, topic: str, encoding: Encoding) -> bytes:
        """Return the frames that carry the message, ready for a socket.

        A client is sent ``topic`` as it spells it.
        """
        key = topic, encoding
        frames = self._frames.get(key)
        if frames is None:
            if len(self._frames) >= _MAX_KEPT:
                self._frames.clear()
            frames = self._frames[key] = self._encode(topic, encoding)
        return frames

    def number(self, seq: int) -> None:
        """Give its header, if it has one, a number, whatever the client says."""
        if self.structure.is_numbered:
            self.message["header"]["seq"] = seq

    def _encode(self, topic: str, encoding: Encoding) -> bytes:
        if encoding.compression == "cbor":
            return _binary(topic, _tagged(self.structure, self.message))
        if encoding.compression == "cbor-raw":
            content = _packed(self.structure, self.message)
            return _binary(topic, {**now(), "bytes": content})
        operation = {"op": "publish", "topic": topic, "msg": self.message}
        return text_frames(operation, encoding)


def text_frames(operation: dict[str, Any], encoding: Encoding = PLAIN) -> bytes:
    """Return the frames that carry an operation as text, ready to be written to a socket."""
    content = to_json(operation)
    if encoding.compression == "png":
        content = to_json({"op": "png", "data": png(content)})
    size = encoding.fragment_size
    if size is None or len(text := content.decode()) <= size:
        return _frame(OP_TEXT, content)
    size = max(size, math.ceil(len(text) / _MAX_FRAGMENTS))
    fragment = {"op": "fragment", "id": str(next(_fragment_ids))}
    starts = range(0, len(text), size)
    fragments = (
        {**fragment, "data": text[start : start + size], "num": number, "total": len(starts)}
        for number, start in enumerate(starts)
    )
    return b"".join(_frame(OP_TEXT, to_json(each)) for each in fragments)


def png(content: bytes) -> str:
    """Return a text as the pixels of a square PNG image in base64, padded with newlines."""
    n_pixels = math.ceil(len(content) / 3)
    width = max(math.isqrt(n_pixels), 1)
    height = max(math.ceil(n_pixels / width), 1)
    content = content.ljust(3 * width * height, b"\n")
    rows = (content[start : start + 3 * width] for start in range(0, len(content), 3 * width))
    image = b"".join(
        (
            b"\x89PNG\r\n\x1a\n",
            _chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)),
            _chunk(b"IDAT", zlib.compress(b"".join(b"\0" + row for row in rows))),
            _chunk(b"IEND", b""),
        )
    )
    return base64.b64encode(image).decode("ascii")


def _chunk(kind: bytes, content: bytes) -> bytes:
    checked = kind + content
    return struct.pack(">I", len(content)) + checked + struct.pack(">I", zlib.crc32(checked))


def _binary(topic: str, message: Any) -> bytes:
    return _frame(OP_BINARY, cbor2.dumps({"op": "publish", "topic": topic, "msg": message}))


def _frame(opcode: Opcode, content: bytes) -> bytes:
    """Return an unmasked frame; as ``Frame.serialize``, which takes five times as long."""
    if len(content) < 126:
        return bytes((0x80 | opcode, len(content))) + content
    if len(content) < 1 << 16:
        return struct.pack("!BBH", 0x80 | opcode, 126, len(content)) + content
    return struct.pack("!BBQ", 0x80 | opcode, 127, len(content)) + content


def _tagged(structure: Structure, message: dict[str, Any]) -> dict[str, Any]:
    """Return a message as CBOR is to have it: bytes as bytes, numbers as typed arrays."""
    return {
        field.name: _tagged_field(field, structure, message[field.name])
        for field in structure.definition.fields
    }


def _packed(structure: Structure, message: dict[str, Any]) -> bytes:
    """Return a message as ROS nodes send it to each other: in ROS 2 as CDR."""
    packer = _Packer(is_cdr=structure.ros != 1)
    packer.add_message(structure, message)
    return bytes(packer.content) if structure.ros == 1 else _CDR + packer.content


def _tagged_field(field: Field, structure: Structure, value: Any) -> Any:
    nested = structure.nested.get(field.type)
    if field.length == SCALAR:
        return value if nested is None else _tagged(nested, value)
    if nested is not None:
        return [_tagged(nested, element) for element in value]
    if field.type in BYTE_ARRAYS:
        return base64.b64decode(value)
    if field.type in _TAGS:
        return cbor2.CBORTag(_TAGS[field.type], _packed_numbers(field.type, value))
    return value


class _Packer:
    """Puts what ROS nodes send to each other together, in ``content``."""

    def __init__(self, *, is_cdr: bool) -> None:
        self._is_cdr = is_cdr
        self.content = bytearray()

    def add_message(self, structure: Structure, message: dict[str, Any]) -> None:
        """Add the fields of a message."""
        for field in structure.definition.fields:
            value, nested = message[field.name], structure.nested.get(field.type)
            if field.length == SCALAR:
                self._add(field.type, nested, value)
            else:
                self._add_array(field, nested, value)
        if self._is_cdr and not structure.definition.fields:
            self.content.append(0)  # every type has a member there

    def _add_array(self, field: Field, nested: Structure | None, value: Any) -> None:
        values = base64.b64decode(value) if field.type in BYTE_ARRAYS else value
        if field.length == VARIABLE:
            self._add_numbers("uint32", [len(values)])
        if field.type in FORMATS:
            self._add_numbers(field.type, values)
        else:
            for each in values:
                self._add(field.type, nested, each)

    def _add(self, type_name: str, nested: Structure | None, value: Any) -> None:
        if nested is not None:
            self.add_message(nested, value)
        elif type_name in TEXTS:
            text = value.encode() + bytes(self._is_cdr)
            self._add_numbers("uint32", [len(text)])
            self.content += text
        elif type_name in TIMES:
            self._add_numbers("uint32" if type_name == "time" else "int32", [*value.values()])
        else:
            self._add_numbers(type_name, [value])

    def _add_numbers(self, type_name: str, values: Sequence[Any]) -> None:
        if self._is_cdr and values:
            self.content += bytes(-len(self.content) % struct.calcsize(FORMATS[type_name]))
        self.content += _packed_numbers(type_name, values)


def _packed_numbers(type_name: str, values: Sequence[Any]) -> bytes:
    if type_name == "float32":
        values = [_single(value) for value in values]
    return struct.pack(f"<{len(values)}{FORMATS[type_name]}", *values)


def _single(value: float) -> float:
    """Return a number that single precision can hold: too large ones become infinite."""
    try:
        struct.pack("<f", value)
    except OverflowError:
        return float("inf") if value > 0 else float("-inf")
    return value
