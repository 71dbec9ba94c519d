"""One end of a websocket, as bytes: messages out of what comes, and what is to be written.

``websockets`` shakes hands, answers pings, closes, and judges what is wrong. Whole text frames,
which is nearly all that a client and a rosbridge server send, are cut out here, as in C.
"""

import os
import struct
from collections.abc import Iterator
from typing import NamedTuple, TypeAlias

from websockets.client import ClientProtocol
from websockets.exceptions import InvalidStatus
from websockets.frames import OP_BINARY, OP_CONT, OP_PONG, OP_TEXT, Frame
from websockets.http11 import Request, Response
from websockets.protocol import SERVER, State
from websockets.server import ServerProtocol
from websockets.uri import parse_uri

try:
    from websockets.speedups import apply_mask
except ImportError:  # where it has no compiled part
    from websockets.utils import apply_mask

_END_OF_HEAD = b"\r\n\r\n"
_WHOLE_TEXT = 0x80 | OP_TEXT
_MASKED = 0x80
_MASK_BYTES = 4
_MASKS_DRAWN = 1024
_LENGTH_BYTES = {126: 2, 127: 8}
"""How many bytes a greater length of a frame takes, by what stands in the place of a small one."""


class Message(NamedTuple):
    """What one end says to the other."""

    content: bytes | bytearray
    is_text: bool


class Pong(NamedTuple):
    """What answers a ping, and goes behind all that was said before."""

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
        self._said: list[bytes] = []
        self._masks: Iterator[bytes] = iter(())
        self._is_text = True
        self._is_whole = True

    @property
    def is_open(self) -> bool:
        """Whether hands were shaken, and nobody took leave."""
        return self.protocol.state is State.OPEN

    @property
    def status(self) -> int | None:
        """The status of HTTP by which the server refused to shake hands, if it did."""
        error = self.protocol.handshake_exc
        return error.response.status_code if isinstance(error, InvalidStatus) else None

    @property
    def n_bytes(self) -> int:
        """What came of messages that are not whole yet."""
        return len(self._waiting) + len(self._parts) + len(self.protocol.reader.buffer)

    def send_text(self, content: bytes) -> None:
        """Say a text, as a client; ``data_to_send`` has it."""
        mask = next(self._masks, None)
        if mask is None:  # a call of the system for each takes longer than all the rest
            self._masks = _masks()
            mask = next(self._masks)
        n_bytes = len(content)
        if n_bytes < 126:
            head = struct.pack("!BB", _WHOLE_TEXT, _MASKED | n_bytes)
        elif n_bytes < 1 << 16:
            head = struct.pack("!BBH", _WHOLE_TEXT, _MASKED | 126, n_bytes)
        else:
            head = struct.pack("!BBQ", _WHOLE_TEXT, _MASKED | 127, n_bytes)
        self._said += head, mask, apply_mask(content, mask)

    def data_to_send(self) -> list[bytes]:
        """Return what is to be written, in parts; an empty one last ends the connection."""
        said, self._said = self._said, []
        return [*said, *self.protocol.data_to_send()]

    def receive(self, data: bytes | memoryview) -> Iterator[Event]:
        """Take bytes; yield what they complete, one after the other."""
        if self.protocol.state is State.CONNECTING:
            head, data = self._head(bytes(data))
            yield from self._judged(head)
        self._waiting += data
        position = 0
        while (bounds := self._bounds(position)) is not None:
            start, end = bounds
            is_refused = self._is_refused(position, end - start)
            if is_refused:
                end = len(self._waiting)  # ``websockets`` says why
            elif end > len(self._waiting):
                break
            if is_refused or not self._is_whole or self._waiting[position] != _WHOLE_TEXT:
                yield from self._judged(bytes(self._waiting[position:end]))
            else:
                yield Message(self._unmasked(start, end), is_text=True)
            position = end
        del self._waiting[:position]

    def _head(self, data: bytes) -> tuple[bytes, bytes]:
        """Return what belongs to the handshake, and what comes after it."""
        end = (self._tail + data).find(_END_OF_HEAD)
        if end < 0:
            self._tail = (self._tail + data)[1 - len(_END_OF_HEAD) :]
            return data, b""
        end += len(_END_OF_HEAD) - len(self._tail)
        return data[:end], data[end:]

    def _bounds(self, position: int) -> tuple[int, int] | None:
        """Return where the content of the next frame begins and ends, once that is known."""
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
        """Return whether a frame comes too late, is too long, or masked where it must not be."""
        most = self.protocol.max_message_size
        return (
            not self.is_open
            or bool(self._waiting[position + 1] & _MASKED) != self._is_masked
            or (most is not None and length > most)
        )

    def _unmasked(self, start: int, end: int) -> bytes | bytearray:
        content = self._waiting[start:end]
        if not self._is_masked:
            return content
        return apply_mask(content, bytes(self._waiting[start - _MASK_BYTES : start]))

    def _judged(self, data: bytes) -> Iterator[Event]:
        """Have ``websockets`` take bytes; yield what they complete."""
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


def _masks() -> Iterator[bytes]:
    """Yield some masks that nobody can guess."""
    drawn = os.urandom(_MASKS_DRAWN * _MASK_BYTES)
    return (drawn[start : start + _MASK_BYTES] for start in range(0, len(drawn), _MASK_BYTES))


def client_stream(url: str) -> Stream:
    """Return a client's end, which has said what it asks for."""
    protocol = ClientProtocol(parse_uri(url), max_size=None)
    protocol.send_request(protocol.connect())
    return Stream(protocol)
