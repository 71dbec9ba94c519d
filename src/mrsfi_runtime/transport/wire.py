"""roslibpy's classes over a faster connection, the default of ``--client``.

Messages sent by one callback leave in one write, and received data is acknowledged at once.
"""

import asyncio
import socket
from contextlib import suppress
from threading import get_ident
from typing import Any, cast

import roslibpy
from roslibpy.comm import RosBridgeProtocol
from roslibpy.comm.comm_asyncio import LOGGER, AsyncioRosBridgeClientFactory
from roslibpy.core import MessageEncoder

from mrsfi_bridge.frames import Message, client_stream, from_json, to_json

_ENCODER = MessageEncoder(separators=(",", ":"))
_QUICKACK = getattr(socket, "TCP_QUICKACK", None)  # Linux
_READ_BYTES = 1 << 18


class WireProtocol(RosBridgeProtocol, asyncio.BufferedProtocol):  # type: ignore[misc]
    """A connection; all but ``send_message`` and ``send_close`` run in the loop's thread."""

    def __init__(self, factory: "WireFactory") -> None:
        super().__init__()
        self.factory = factory
        self._loop = factory.manager.loop
        self._thread = get_ident()
        self._manual_disconnect = False  # roslibpy's factory reads it
        self._stream = client_stream(factory.url)
        self._buffer = memoryview(bytearray(_READ_BYTES))
        self._is_due = False

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Begin the handshake."""
        self._transport = cast("asyncio.Transport", transport)
        self._socket = transport.get_extra_info("socket")
        self._flush()

    def get_buffer(self, _: int) -> memoryview:
        """Return a buffer for received data; by default asyncio makes one for each read."""
        return self._buffer

    def buffer_updated(self, nbytes: int) -> None:
        """Process received data."""
        for event in self._stream.receive(self._buffer[:nbytes]):
            if isinstance(event, Message):
                self._take(event.content)
            elif self._stream.is_open:
                self.factory.ready(self)
            else:
                self.factory.status = self._stream.status
        if not self._flush() and _QUICKACK is not None:
            with suppress(OSError):  # the connection ended just now
                self._socket.setsockopt(socket.IPPROTO_TCP, _QUICKACK, 1)

    def eof_received(self) -> bool:
        """Close, since the server did."""
        self._stream.protocol.receive_eof()
        self._flush()
        return False

    def connection_lost(self, _: Exception | None) -> None:
        """Notify the factory."""
        self.factory.connection_lost(self)

    def send_ros_message(self, message: Any) -> None:
        """Send a message of roslibpy."""
        content = to_json(message.data)
        if b"null" in content:  # it may stand for NaN, which a genuine server wants as such
            content = _ENCODER.encode(message.data).encode()
        self.send_message(content)

    def send_message(self, payload: bytes) -> None:
        """Send encoded data."""
        if get_ident() == self._thread:
            self._send(payload)
        else:
            self._loop.call_soon_threadsafe(self._send, payload)

    def send_close(self) -> None:
        """Close the connection."""
        self._manual_disconnect = True
        self._loop.call_soon_threadsafe(self._close)

    def _take(self, payload: bytes | bytearray) -> None:
        try:
            message = from_json(payload)
            if message["op"] == "publish":
                self.factory.emit(message["topic"], message["msg"])
            else:
                self._message_handlers[message["op"]](message)
        except Exception:  # noqa: BLE001 - as roslibpy does; callbacks report to their listener
            LOGGER.exception("Error in a callback, or an invalid message; the message is skipped.")

    def _send(self, payload: bytes) -> None:
        if self._stream.is_open:
            self._stream.send_text(payload)
            if not self._is_due:
                self._is_due = True
                self._loop.call_soon(self._flush)

    def _close(self) -> None:
        if self._stream.is_open:
            self._stream.protocol.send_close(1000)
            self._flush()

    def _flush(self) -> bool:
        """Write all pending data at once; return whether there was any."""
        self._is_due = False
        data = self._stream.data_to_send()
        if data and not self._transport.is_closing():
            self._transport.write(b"".join(data))
            if not data[-1]:
                self._transport.close()
        return bool(data)


class WireFactory(AsyncioRosBridgeClientFactory):  # type: ignore[misc]
    """roslibpy's asyncio factory, for connections of ``WireProtocol``.

    ``status`` is the HTTP status with which the server refused the last one.
    """

    status: int | None = None

    def __call__(self) -> WireProtocol:
        """Return a new connection."""
        return WireProtocol(self)


class WireRos(roslibpy.Ros):  # type: ignore[misc]
    """roslibpy's ``Ros`` over a ``WireProtocol``."""

    def __init__(self, url: str) -> None:
        self._id_counter = 0
        self.factory = WireFactory(url)
        self.is_connecting = False
        self.connect()
