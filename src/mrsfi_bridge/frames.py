"""Data on a socket: JSON, encodings of messages, frames of a websocket.

``to_json`` and ``from_json`` use ``orjson`` if it is installed, which is faster. An
``Outgoing`` is a published message in normal form (see ``structures``). It is encoded once for
each ``Encoding`` that clients request: JSON, PNG, CBOR with typed arrays, or the bytes that ROS
nodes exchange. A text may be cut into fragments.

A ``Stream`` is one end of a websocket as bytes: it takes received bytes, yields messages, and
returns bytes to write. The ``websockets`` package performs handshakes, answers pings, closes and
detects errors. Whole text frames, which are nearly all, are parsed here, because that is
faster. The server and the client of ``--client wire`` both use it.

This module opens no socket and handles no topic. Begin with ``Outgoing``, then ``Stream``.

References
----------
https://github.com/RobotWebTools/rosbridge_suite/blob/ros1/ROSBRIDGE_PROTOCOL.md, sections 3.1
and 3.2. RFC 8949 (CBOR), RFC 8746 (typed arrays). What ROS nodes send each other:
http://wiki.ros.org/roscpp/Overview/MessagesSerializationAndAdaptingTypes, and CDR of the Object
Management Group.
"""

import base64
import json
import math
import os
import struct
import zlib
from collections.abc import Iterator, Sequence
from contextlib import suppress
from itertools import count
from typing import Any, NamedTuple, TypeAlias

import cbor2
from websockets.client import ClientProtocol
from websockets.exceptions import InvalidStatus
from websockets.frames import OP_BINARY, OP_CONT, OP_PONG, OP_TEXT, Frame, Opcode
from websockets.http11 import Request, Response
from websockets.protocol import SERVER, State
from websockets.server import ServerProtocol
from websockets.uri import parse_uri

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

try:
    import orjson
except ImportError:  # of the extra ``fast``
    orjson = None  # type: ignore[assignment, unused-ignore]
try:
    from websockets.speedups import apply_mask
except ImportError:  # where it has no compiled part
    from websockets.utils import apply_mask

_encode = json.JSONEncoder(allow_nan=False, separators=(",", ":"), default=dict).encode


def to_json(value: Any) -> bytes:
    """Return a value as JSON; NaN and infinite numbers become null."""
    if orjson is not None:
        with suppress(TypeError):  # it is a whole number of more than 64 bits, say
            content: bytes = orjson.dumps(value, default=dict)
            return content
    try:
        return _encode(value).encode()
    except ValueError:
        return _encode(_finite(value)).encode()


def from_json(content: bytes | bytearray | str) -> Any:
    """Return the value of a JSON text; ``ValueError`` or ``RecursionError`` if it is invalid."""
    if orjson is not None:
        with suppress(ValueError):  # it contains NaN, say
            return orjson.loads(content)
    return json.loads(content if isinstance(content, str) else content.decode())


def _finite(value: Any) -> Any:
    if isinstance(value, float):
        return value if -float("inf") < value < float("inf") else None
    if isinstance(value, dict):
        return {key: _finite(part) for key, part in value.items()}
    if isinstance(value, list):
        return [_finite(part) for part in value]
    return value


_MAX_KEPT = 8  # encodings of one message that are kept

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
    """The encoding that a client requests; the compression is one of ``COMPRESSIONS``.

    Texts of more than ``fragment_size`` characters are cut into at most 4,096 fragments. Binary
    frames stay whole.
    """

    compression: str = "none"
    fragment_size: int | None = None


PLAIN = Encoding()


class Outgoing:
    """A published message in its normal form, which must not be changed.

    It is encoded once for any number of clients.
    """

    __slots__ = ("_frames", "message", "structure")

    def __init__(self, structure: Structure, message: dict[str, Any]) -> None:
        self.structure = structure
        self.message = message
        self._frames: dict[tuple[str, Encoding], bytes] = {}

    def frames(self, topic: str, encoding: Encoding) -> bytes:
        """Return the frames that carry the message, ready for a socket.

        ``topic`` is the client's own spelling.
        """
        key = topic, encoding
        frames = self._frames.get(key)
        if frames is None:
            if len(self._frames) >= _MAX_KEPT:
                self._frames.clear()
            frames = self._frames[key] = self._encode(topic, encoding)
        return frames

    def number(self, seq: int) -> None:
        """Set the number of the header, if there is one, in place of the client's."""
        if self.structure.has_header and self.structure.ros == 1:
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
    size = max(size, math.ceil(len(text) / 4096))
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
    """Return an unmasked frame, as ``Frame.serialize`` does in five times the time."""
    return _frame_head(opcode, len(content)) + content


def _frame_head(opcode: Opcode, n_bytes: int, mask: int = 0) -> bytes:
    """Return the head of a whole frame of so many bytes."""
    if n_bytes < 126:
        return bytes((0x80 | opcode, mask | n_bytes))
    if n_bytes < 1 << 16:
        return struct.pack("!BBH", 0x80 | opcode, mask | 126, n_bytes)
    return struct.pack("!BBQ", 0x80 | opcode, mask | 127, n_bytes)


def _tagged(structure: Structure, message: dict[str, Any]) -> dict[str, Any]:
    """Return a message for CBOR: bytes as bytes, numbers as typed arrays."""
    return {
        field.name: _tagged_field(field, structure, message[field.name])
        for field in structure.definition.fields
    }


def _packed(structure: Structure, message: dict[str, Any]) -> bytes:
    """Return a message as ROS nodes send it to each other: in ROS 2 as CDR."""
    packer = _Packer(is_cdr=structure.ros != 1)
    packer.add_message(structure, message)
    # the four bytes say that little-endian CDR follows
    return bytes(packer.content) if structure.ros == 1 else b"\0\1\0\0" + packer.content


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
    """Serializes messages as ROS nodes exchange them, into ``content``."""

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
    """Return a number in the range of single precision; larger ones become infinite."""
    try:
        struct.pack("<f", value)
    except OverflowError:
        return float("inf") if value > 0 else float("-inf")
    return value


_END_OF_HEAD = b"\r\n\r\n"
_WHOLE_TEXT = 0x80 | OP_TEXT
_MASKED = 0x80
_MASK_BYTES = 4
_LENGTH_BYTES = {126: 2, 127: 8}
"""Number of bytes of an extended frame length, by the value in the short length field."""


class Message(NamedTuple):
    """A message of the other end."""

    content: bytes | bytearray
    is_text: bool


class Pong(NamedTuple):
    """The answer to a ping; it follows all earlier messages."""

    content: bytes


Event: TypeAlias = Message | Pong | Request | Response


class Stream:
    """One end of a websocket, by the ``protocol`` of ``websockets``."""

    def __init__(self, protocol: ClientProtocol | ServerProtocol) -> None:
        self.protocol = protocol
        self._is_masked = protocol.side is SERVER
        self._tail = b""
        self._waiting = bytearray()
        self._parts = bytearray()
        self._unsent: list[bytes] = []
        self._is_text = True
        self._is_whole = True

    @property
    def is_open(self) -> bool:
        """Whether the handshake is complete and no end has begun to close."""
        return self.protocol.state is State.OPEN

    @property
    def status(self) -> int | None:
        """The HTTP status with which the server refused the handshake, if it did."""
        error = self.protocol.handshake_exc
        return error.response.status_code if isinstance(error, InvalidStatus) else None

    @property
    def n_bytes(self) -> int:
        """Number of received bytes of incomplete messages."""
        return len(self._waiting) + len(self._parts) + len(self.protocol.reader.buffer)

    def send_text(self, content: bytes) -> None:
        """Queue a text of a client for ``data_to_send``."""
        mask = os.urandom(_MASK_BYTES)
        self._unsent += _frame_head(OP_TEXT, len(content), _MASKED), mask, apply_mask(content, mask)

    def data_to_send(self) -> list[bytes]:
        """Return the bytes to write, in parts; an empty last part ends the connection."""
        frames, self._unsent = self._unsent, []
        return [*frames, *self.protocol.data_to_send()]

    def receive(self, data: bytes | memoryview) -> Iterator[Event]:
        """Take bytes; yield the completed events."""
        if self.protocol.state is State.CONNECTING:
            head, data = self._head(bytes(data))
            yield from self._judged(head)
        self._waiting += data
        position = 0
        while (bounds := self._bounds(position)) is not None:
            start, end = bounds
            is_refused = self._is_refused(position, end - start)
            if is_refused:
                end = len(self._waiting)  # ``websockets`` finds the reason
            elif end > len(self._waiting):
                break
            if is_refused or not self._is_whole or self._waiting[position] != _WHOLE_TEXT:
                yield from self._judged(bytes(self._waiting[position:end]))
            else:
                content: bytes | bytearray = self._waiting[start:end]
                if self._is_masked:
                    mask = bytes(self._waiting[start - _MASK_BYTES : start])
                    content = apply_mask(content, mask)
                yield Message(content, is_text=True)
            position = end
        del self._waiting[:position]

    def _head(self, data: bytes) -> tuple[bytes, bytes]:
        """Return the bytes of the handshake, and the rest."""
        end = (self._tail + data).find(_END_OF_HEAD)
        if end < 0:
            self._tail = (self._tail + data)[1 - len(_END_OF_HEAD) :]
            return data, b""
        end += len(_END_OF_HEAD) - len(self._tail)
        return data[:end], data[end:]

    def _bounds(self, position: int) -> tuple[int, int] | None:
        """Return start and end of the content of the next frame, once known."""
        waiting, start = self._waiting, position + 2
        if len(waiting) < start:
            return None
        length = waiting[position + 1] & ~_MASKED
        if n_more := _LENGTH_BYTES.get(length, 0):
            if len(waiting) < start + n_more:
                return None
            length = int.from_bytes(waiting[start : start + n_more], "big")
            start += n_more
        if self._is_masked:
            start += _MASK_BYTES
        return start, start + length

    def _is_refused(self, position: int, length: int) -> bool:
        """Return whether a frame is too late, too long, or wrongly masked."""
        most = self.protocol.max_message_size
        return (
            not self.is_open
            or bool(self._waiting[position + 1] & _MASKED) != self._is_masked
            or (most is not None and length > most)
        )

    def _judged(self, data: bytes) -> Iterator[Event]:
        """Pass bytes to ``websockets``; yield the completed events."""
        self.protocol.receive_data(data)
        for event in self.protocol.events_received():
            if not isinstance(event, Frame):
                yield event
            elif event.opcode is OP_PONG:
                yield Pong(bytes(event.data))
            elif event.opcode in {OP_TEXT, OP_BINARY, OP_CONT}:
                if event.opcode is not OP_CONT:
                    self._is_text = event.opcode is OP_TEXT
                self._parts += event.data
                self._is_whole = event.fin
                if event.fin:
                    content, self._parts = self._parts, bytearray()
                    yield Message(content, self._is_text)


def client_stream(url: str) -> Stream:
    """Return a client's end, with its handshake request to be sent."""
    protocol = ClientProtocol(parse_uri(url), max_size=None)
    protocol.send_request(protocol.connect())
    return Stream(protocol)
