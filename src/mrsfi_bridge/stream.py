"""One end of a websocket, as bytes: messages out of what comes, and what is to be written.

``websockets`` shakes hands, answers pings, closes, and judges what is wrong. Whole text frames,
which is nearly all that a client and a rosbridge server send, are cut out here, as in C.
"""

from collections.abc import Iterator
from typing import NamedTuple, TypeAlias

from websockets.client import ClientProtocol
from websockets.frames import OP_BINARY, OP_CONT, OP_TEXT, Frame
from websockets.frames import apply_mask  # type: ignore[attr-defined] # in C, where it may be
from websockets.http11 import Request, Response
from websockets.protocol import SERVER, State
from websockets.server import ServerProtocol
from websockets.uri import parse_uri

_END_OF_HEAD = b"\r\n\r\n"
_WHOLE_TEXT = 0x80 | OP_TEXT
_MASKED = 0x80
_MASK_BYTES = 4
_LENGTH_BYTES = {126: 2, 127: 8}
"""How many bytes a greater length of a frame takes, by what stands in the place of a small one."""


class Message(NamedTuple):
    """What one end says to the other."""

    content: bytes | bytearray
    is_text: bool


Event: TypeAlias = Message | Request | Response


class Stream:
    """One end of a websocket, by the ``protocol`` of ``websockets``."""

    def __init__(self, protocol: ClientProtocol | ServerProtocol) -> None:
        self.protocol = protocol
        self._mask = _MASKED if protocol.side is SERVER else 0
        self._tail = b""
        self._waiting = bytearray()
        self._parts = bytearray()
        self._is_text = True
        self._is_whole = True

    @property
    def is_open(self) -> bool:
        """Whether hands were shaken, and nobody took leave."""
        return self.protocol.state is State.OPEN

    @property
    def n_bytes(self) -> int:
        """What came of messages that are not whole yet."""
        return len(self._waiting) + len(self._parts) + len(self.protocol.reader.buffer)

    def receive(self, data: bytes | memoryview) -> Iterator[Event]:
        """Take bytes; yield what they complete, one after the other."""
        if self.protocol.state is State.CONNECTING:
            head, data = self._head(bytes(data))
            yield from self._judged(head)
        self._waiting += data
        position = 0
        while (frame := self._frame(position)) is not None:
            content, end = frame
            if content is None:
                yield from self._judged(bytes(self._waiting[position:end]))
            else:
                yield Message(content, is_text=True)
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

    def _frame(self, position: int) -> tuple[bytearray | bytes | None, int] | None:
        """Return the content of the next frame and its end; ``None`` unless it is there.

        There is no content if it is no whole text, or something is wrong with it: that is for
        ``websockets`` to say.
        """
        waiting = self._waiting
        n_waiting = len(waiting) - position
        if n_waiting < 2:
            return None
        if not self.is_open:
            return None, len(waiting)
        start, length = position + 2, waiting[position + 1] ^ self._mask
        if n_more := _LENGTH_BYTES.get(length, 0):
            if n_waiting < 2 + n_more:
                return None
            length = int.from_bytes(waiting[start : start + n_more], "big")
            start += n_more
        most = self.protocol.max_message_size
        if length >= _MASKED and not n_more or (most is not None and length > most):
            return None, len(waiting)  # masked where it must not be or the reverse, or too much
        if self._mask:
            start += _MASK_BYTES
        end = start + length
        if end > len(waiting):
            return None
        if waiting[position] != _WHOLE_TEXT or not self._is_whole:
            return None, end
        if self._mask:
            return apply_mask(waiting[start:end], waiting[start - _MASK_BYTES : start]), end
        return waiting[start:end], end

    def _judged(self, data: bytes) -> Iterator[Event]:
        """Have ``websockets`` take bytes; yield what they complete."""
        self.protocol.receive_data(data)
        for event in self.protocol.events_received():
            if not isinstance(event, Frame):
                yield event
            elif event.opcode in {OP_TEXT, OP_BINARY, OP_CONT}:
                if event.opcode is not OP_CONT:
                    self._is_text = event.opcode is OP_TEXT
                self._parts += event.data
                self._is_whole = event.fin
                if event.fin:
                    content, self._parts = self._parts, bytearray()
                    yield Message(content, self._is_text)


def client_stream(url: str) -> Stream:
    """Return a client's end, which has said what it asks for."""
    protocol = ClientProtocol(parse_uri(url), max_size=None)
    protocol.send_request(protocol.connect())
    return Stream(protocol)
