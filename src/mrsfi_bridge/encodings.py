"""Messages on their way to clients: JSON, PNG, CBOR, whole or in fragments.

References
----------
https://github.com/RobotWebTools/rosbridge_suite/blob/ros1/ROSBRIDGE_PROTOCOL.md, sections 3.1
and 3.2.
"""

import base64
import json
import math
import struct
import zlib
from itertools import count
from typing import Any, NamedTuple

from websockets.frames import OP_BINARY, OP_TEXT, Opcode

from mrsfi_bridge.structures import Structure, now
from mrsfi_bridge.wire import cbor, packed, tagged

COMPRESSIONS = ("none", "png", "cbor", "cbor-raw")


class Encoding(NamedTuple):
    """How a client wants what it is sent.

    Parameters
    ----------
    compression
        Member of ``COMPRESSIONS``.
    fragment_size
        Longest text in letters; longer ones are cut into fragments, but into no more than
        4,096. Binary frames stay whole.
    """

    compression: str = "none"
    fragment_size: int | None = None


PLAIN = Encoding()

_encode = json.JSONEncoder(allow_nan=False, separators=(",", ":")).encode
_MAX_FRAGMENTS = 4096
_MAX_KEPT = 8
"""Encodings of one message that are kept."""

_fragment_ids = count()


class Outgoing:
    """A published message, encoded once however many clients receive it.

    Parameters
    ----------
    structure
        Type of the message.
    message
        Its normal form; nobody may change it.
    """

    __slots__ = ("_frames", "message", "structure")

    def __init__(self, structure: Structure, message: dict[str, Any]) -> None:
        self.structure = structure
        self.message = message
        self._frames: dict[tuple[str, Encoding], bytes] = {}

    def frames(self, topic: str, encoding: Encoding) -> bytes:
        """Return the frames that carry the message, ready to be written to a socket.

        Parameters
        ----------
        topic
            The topic as the client spells it.
        encoding
            How the client wants it.
        """
        key = topic, encoding
        frames = self._frames.get(key)
        if frames is None:
            if len(self._frames) >= _MAX_KEPT:
                self._frames.clear()
            frames = self._frames[key] = self._encode(topic, encoding)
        return frames

    def _encode(self, topic: str, encoding: Encoding) -> bytes:
        if encoding.compression == "cbor":
            return _binary(topic, tagged(self.structure, self.message))
        if encoding.compression == "cbor-raw":
            content = packed(self.structure, self.message)
            return _binary(topic, {**now(), "bytes": content})
        return text_frames({"op": "publish", "topic": topic, "msg": self.message}, encoding)


def text_frames(operation: dict[str, Any], encoding: Encoding = PLAIN) -> bytes:
    """Return the frames that carry an operation as text, ready to be written to a socket."""
    text = json_text(operation)
    if encoding.compression == "png":
        text = json_text({"op": "png", "data": png(text)})
    size = encoding.fragment_size
    if size is None or len(text) <= size:
        return _frame(OP_TEXT, text.encode())
    size = max(size, math.ceil(len(text) / _MAX_FRAGMENTS))
    return b"".join(_frame(OP_TEXT, part.encode()) for part in _fragments(text, size))


def json_text(value: Any) -> str:
    """Return a value as JSON; a number that is none becomes null."""
    try:
        return _encode(value)
    except ValueError:
        return _encode(_finite(value))


def png(text: str) -> str:
    """Return a text as the pixels of a square PNG image in base64, padded with newlines."""
    content = text.encode()
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
    return _frame(OP_BINARY, cbor({"op": "publish", "topic": topic, "msg": message}))


def _frame(opcode: Opcode, content: bytes) -> bytes:
    """Return an unmasked frame; as ``Frame.serialize``, which takes five times as long."""
    if len(content) < 126:
        return bytes((0x80 | opcode, len(content))) + content
    if len(content) < 1 << 16:
        return struct.pack("!BBH", 0x80 | opcode, 126, len(content)) + content
    return struct.pack("!BBQ", 0x80 | opcode, 127, len(content)) + content


def _fragments(text: str, size: int) -> list[str]:
    total = math.ceil(len(text) / size)
    fragment_id = str(next(_fragment_ids))
    return [
        json_text(
            {
                "op": "fragment",
                "id": fragment_id,
                "data": text[number * size : (number + 1) * size],
                "num": number,
                "total": total,
            }
        )
        for number in range(total)
    ]


def _finite(value: Any) -> Any:
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, dict):
        return {key: _finite(part) for key, part in value.items()}
    if isinstance(value, list):
        return [_finite(part) for part in value]
    return value
