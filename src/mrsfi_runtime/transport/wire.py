"""roslibpy's classes over a connection of our own, at the speed of the wire.

What a callback sends leaves in one write, and what comes is acknowledged at once. Handshake,
pings and farewell are those of ``websockets``; whole text frames, which is nearly all that a
rosbridge server sends, are cut out here.
"""

import asyncio
import json
import socket
from contextlib import suppress
from threading import get_ident
from typing import Any, cast

import roslibpy
from roslibpy.comm import RosBridgeProtocol
from roslibpy.comm.comm_asyncio import LOGGER, AsyncioRosBridgeClientFactory
from roslibpy.core import MessageEncoder
from websockets.client import ClientProtocol
from websockets.frames import OP_CONT, OP_TEXT, Frame
from websockets.protocol import State
from websockets.uri import parse_uri

_ENCODE = MessageEncoder(separators=(",", ":")).encode
_DECODE = json.JSONDecoder().raw_decode
_QUICKACK = getattr(socket, "TCP_QUICKACK", None)  # Linux
_END_OF_HEAD = b"\r\n\r\n"
_WHOLE_TEXT = 0x80 | OP_TEXT
_LENGTHS = {126: 2, 127: 8}
"""Bytes in which longer lengths of a frame stand, by what stands in the place of short ones."""


class WireProtocol(RosBridgeProtocol, asyncio.Protocol):
    """A connection; all but ``send_message`` and ``send_close`` run in the loop's thread."""

    def __init__(self, factory: "WireFactory") -> None:
        super().__init__()
        self.factory = factory
        self._loop = factory.manager.loop
        self._thread = get_ident()
        self._manual_disconnect = False  # roslibpy's factory reads it
        self._websocket = ClientProtocol(parse_uri(factory.url), max_size=None)
        self._waiting = bytearray()
        self._parts: list[bytes] = []
        self._is_due = False

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Begin to shake hands."""
        self._transport = cast("asyncio.Transport", transport)
        self._socket = transport.get_extra_info("socket")
        self._websocket.send_request(self._websocket.connect())
        self._flush()

    def data_received(self, data: bytes) -> None:
        """Take what came."""
        if _QUICKACK is not None:
            with suppress(OSError):  # the connection ended just now
                self._socket.setsockopt(socket.IPPROTO_TCP, _QUICKACK, 1)
        self._waiting += data
        if self._websocket.state is State.CONNECTING:
            self._shake_hands()
        if self._websocket.state is not State.CONNECTING:
            self._take_frames()

    def eof_received(self) -> bool:
        """Close, since the server did."""
        self._websocket.receive_eof()
        self._flush()
        return False

    def connection_lost(self, exc: Exception | None) -> None:
        """Tell those who listen."""
        self.factory.connection_lost(self)

    def send_ros_message(self, message: Any) -> None:
        """Send a message of roslibpy."""
        self.send_message(_ENCODE(message.data).encode())

    def send_message(self, payload: bytes) -> None:
        """Send what was encoded."""
        if get_ident() == self._thread:
            self._send(payload)
        else:
            self._loop.call_soon_threadsafe(self._send, payload)

    def send_close(self) -> None:
        """Take leave of the server."""
        self._manual_disconnect = True
        self._loop.call_soon_threadsafe(self._close)

    def _shake_hands(self) -> None:
        end = self._waiting.find(_END_OF_HEAD)
        if end < 0:
            return
        end += len(_END_OF_HEAD)
        self._websocket.receive_data(bytes(self._waiting[:end]))
        del self._waiting[:end]
        self._websocket.events_received()
        if self._websocket.state is State.OPEN:
            self.factory.ready(self)
        self._flush()

    def _take_frames(self) -> None:
        waiting, position = self._waiting, 0
        while len(waiting) - position >= 2:
            start, length = position + 2, waiting[position + 1]
            if n_bytes := _LENGTHS.get(length, 0):
                length = int.from_bytes(waiting[start : start + n_bytes], "big")
                start += n_bytes
            end = start + length
            if end > len(waiting):
                break
            if waiting[position] == _WHOLE_TEXT:
                self._take(waiting[start:end])
            else:
                self._take_other(bytes(waiting[position:end]))
            position = end
        del waiting[:position]

    def _take_other(self, frame: bytes) -> None:
        """Take what is no whole message: parts of one, a ping, a farewell, or nonsense."""
        self._websocket.receive_data(frame)
        for event in self._websocket.events_received():
            if isinstance(event, Frame) and event.opcode in {OP_TEXT, OP_CONT}:
                self._parts.append(bytes(event.data))
                if event.fin:
                    whole, self._parts = b"".join(self._parts), []
                    self._take(whole)
        self._flush()

    def _take(self, payload: bytes | bytearray) -> None:
        try:
            message, _ = _DECODE(payload.decode())
            if message["op"] == "publish":
                self.factory.emit(message["topic"], message["msg"])
            else:
                self._message_handlers[message["op"]](message)
        except Exception:
            LOGGER.exception("Error in a callback, or a message that makes no sense; skipped.")

    def _send(self, payload: bytes) -> None:
        if self._websocket.state is State.OPEN:
            self._websocket.send_text(payload)
            if not self._is_due:
                self._is_due = True
                self._loop.call_soon(self._flush)

    def _close(self) -> None:
        if self._websocket.state is State.OPEN:
            self._websocket.send_close(1000)
            self._flush()

    def _flush(self) -> None:
        self._is_due = False
        data = self._websocket.data_to_send()
        if data and not self._transport.is_closing():
            self._transport.write(b"".join(data))
            if not data[-1]:
                self._transport.close()


class WireFactory(AsyncioRosBridgeClientFactory):
    """roslibpy's factory of asyncio, which makes connections of ours."""

    def __call__(self) -> WireProtocol:
        return WireProtocol(self)


class WireRos(roslibpy.Ros):
    """roslibpy's ``Ros`` over a connection of ours."""

    def __init__(self, url: str) -> None:
        self._id_counter = 0
        self.factory = WireFactory(url)
        self.is_connecting = False
        self.connect()
