"""The server: its sockets from the opening handshake on, its limits, and its barriers.

A ``BridgeServer`` listens. It has one ``Connection`` for each socket, and each connection has a
``Stream`` for the bytes and, after the handshake, a ``Session`` for the operations. All of it runs
in one asyncio loop: a message is processed whole before the next client is served, and the
limit on its length bounds the time. All data for a client leaves in one write
before the loop continues. The server counts the bytes held for and from clients. It
disconnects a client that exceeds a limit, if possible with a ``status``, and serves the others.

A barrier waits until all clients have answered everything sent to them. A client that processes
messages in one thread answers a ping after all earlier messages; by the second pong it has
also sent its answers. This was measured for roslibpy, asyncio and Twisted, and for roslib on Node
(docs/node.md).

Begin with ``Connection.buffer_updated``.
"""

import asyncio
import hmac
import http
import logging
import re
import socket
from asyncio import AbstractEventLoop
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from itertools import count
from typing import Any, cast
from urllib.parse import parse_qs, urlsplit

from websockets.exceptions import PayloadTooBig
from websockets.frames import CloseCode
from websockets.http11 import Request, Response
from websockets.protocol import State
from websockets.server import ServerProtocol
from websockets.typing import Origin

from mrsfi_bridge.errors import NotRunningError
from mrsfi_bridge.frames import Message, Pong, Stream, text_frames
from mrsfi_bridge.session import LOGGER, Hub, Session, provide_rosapi, tell_clients
from mrsfi_bridge.settings import ServerSettings
from mrsfi_bridge.structures import now

ROUNDS = 2  # pings that go to each client, the second when the first is answered


class Barriers:
    """Barriers of all clients of a server; ``is_idle`` says whether all messages were delivered."""

    def __init__(self, loop: AbstractEventLoop, is_idle: Callable[[], bool]) -> None:
        self._loop = loop
        self._is_idle = is_idle
        self._numbers = count(1)
        self._open: dict[bytes, dict[Connection, Callable[[], None]]] = {}

    def begin(
        self,
        clients: Callable[[], list["Connection"]],
        then: Callable[[], None],
        rounds: int = ROUNDS,
    ) -> None:
        """Call a function when all clients have answered so many pings, one after the other.

        Without any client, the function is not called.
        """
        if not self._is_idle():
            self._loop.call_soon(self.begin, clients, then, rounds)
            return
        pinged = clients()
        if not pinged:
            return
        if not rounds:
            then()
            return

        def answered() -> None:
            self.begin(clients, then, rounds - 1)

        content = next(self._numbers).to_bytes(8, "big")
        self._open[content] = dict.fromkeys(pinged, answered)
        for client in pinged:
            client.ping(content)

    def pong(self, client: "Connection", content: bytes) -> None:
        """Take a client's answer to a ping."""
        if client in self._open.get(content, {}):
            self._answered(content, client)

    def gone(self, client: "Connection") -> None:
        """Stop waiting for a client that has left."""
        for content in tuple(self._open):
            if client in self._open.get(content, {}):
                self._answered(content, client)

    def _answered(self, content: bytes, client: "Connection") -> None:
        waiting = self._open[content]
        answered = waiting.pop(client)
        if not waiting:
            del self._open[content]
            answered()


_READ_BYTES = 1 << 18
_CHECKS_S = 0.25
_SHAKING = 256  # sockets beside those of clients: in the handshake, refused, or closing


_QUICKACK = getattr(socket, "TCP_QUICKACK", None)
_WIRE = LOGGER.getChild("websocket")
_WIRE.setLevel(logging.WARNING)
_THIS_MACHINE = re.compile(r"https?://(?:localhost|127\.0\.0\.1|\[::1\])(?::\d+)?")
_FEW_BYTES = 1 << 16  # bytes held for or from a client that are not counted


class Connection(asyncio.BufferedProtocol):
    """The server's end of one socket."""

    def __init__(self, server: "BridgeServer") -> None:
        self._server = server
        self._limits = server.settings.limits
        self._protocol = ServerProtocol(
            # programs, pages of this machine, and those named
            origins=[None, _THIS_MACHINE, *map(Origin, server.settings.origins)],
            max_size=self._limits.frame_bytes,
            logger=_WIRE,
        )
        self._stream = Stream(self._protocol)
        self._session: Session | None = None
        self._outbox: list[bytes] = []
        self._is_answered = False
        self._since = self._heard = self._now()
        self._pinged: float | None = None
        self._ending: float | None = None

    @property
    def is_client(self) -> bool:
        """Whether the handshake succeeded."""
        return self._session is not None

    def _now(self) -> float:
        return self._server.hub.scheduler.time()

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Prepare the socket of a new client."""
        self._transport: asyncio.Transport = cast("asyncio.Transport", transport)
        peer = transport.get_extra_info("peername") or ("?", 0)
        self.name = f"{peer[0]}:{peer[1]}"
        self.details = {"ip_address": str(peer[0]), "connection_time": now()}
        self._socket: socket.socket = transport.get_extra_info("socket")
        self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        if not self._server.enter(self):
            self.abort("too many sockets")

    def get_buffer(self, _: int) -> memoryview:
        """Return a buffer for received data."""
        return self._server.buffer

    def buffer_updated(self, nbytes: int) -> None:
        """Process received data."""
        self._heard = self._now()
        self._pinged = None
        self._is_answered = False
        for event in self._stream.receive(self._server.buffer[:nbytes]):
            if isinstance(event, Message):
                self._take_message(event)
            elif isinstance(event, Pong):
                self._server.barriers.pong(self, event.content)
            elif isinstance(event, Request):
                self._shake_hands(event)
        if self._ending is None and isinstance(self._protocol.parser_exc, PayloadTooBig):
            self._report(f"your message exceeds {self._limits.frame_bytes} bytes, the limit")
        self._flush()
        if _QUICKACK is not None and not self._is_answered:  # a client may wait for it
            with suppress(OSError):
                self._socket.setsockopt(socket.IPPROTO_TCP, _QUICKACK, 1)

    def eof_received(self) -> bool:
        """Close, since the client did."""
        self._protocol.receive_eof()
        self._flush()
        return False

    def connection_lost(self, exc: Exception | None) -> None:
        """Forget the client."""
        if self._session is not None:
            LOGGER.info("%s: left%s", self.name, f" ({exc})" if exc else "")
            self._session.leave()
            self._session = None
            self._server.tell_clients()
        self._outbox.clear()
        self._server.gone(self)
        self._server.flush()

    def check(self, now: float) -> None:
        """End the connection if a handshake, silence or closing takes too long."""
        state = self._protocol.state
        if self._ending is not None or state in {State.CLOSING, State.CLOSED}:
            self._ending = self._ending or now
            if now - self._ending > self._limits.close_s:
                self.abort("did not close")
        elif state is State.CONNECTING:
            if now - self._since > self._limits.handshake_s:
                self.abort("no handshake")
        elif self._pinged is not None:
            if now - self._pinged > self._limits.pong_s:
                self.abort(f"no answer to a ping; silent for {now - self._heard:.0f} s")
        elif now - self._heard > self._limits.ping_s:
            self._pinged = now
            self._protocol.send_ping(b"")
            self._server.dirty(self)

    def write(self) -> None:
        """Write all pending data at once."""
        transport, writes = self._transport, self._outbox
        writes.extend(self._protocol.data_to_send())
        self._outbox = []
        if transport.is_closing():
            return
        is_end = b"" in writes[-1:]
        content = b"".join(writes)
        if content:
            transport.write(content)
            self._is_answered = True  # this also acknowledges received data
        if is_end and transport.can_write_eof():
            transport.write_eof()
        self._count_held()

    def ping(self, content: bytes) -> None:
        """Ping the client after all earlier messages."""
        if self._protocol.state is State.OPEN:
            self._protocol.send_ping(content)
            self._server.dirty(self)

    def close(self, code: int, reason: str) -> None:
        """Close the connection; the client is cut off if that takes too long."""
        if self._protocol.state is State.OPEN:
            self._protocol.send_close(code, reason)
            self._ending = self._now()
        elif self._protocol.state is State.CONNECTING:
            self.abort(reason)
        self._server.dirty(self)

    def refuse(self, reason: str) -> None:
        """Report to the client that it exceeds a limit, and cut it off."""
        if self._ending is not None:
            return
        if self._protocol.state is State.OPEN:
            self._report(reason)
        self.close(CloseCode.TRY_AGAIN_LATER, reason[:120])

    def _report(self, reason: str) -> None:
        """Report the reason to the client before it is disconnected."""
        LOGGER.warning("%s: disconnected: %s", self.name, reason)
        self._outbox.append(text_frames({"op": "status", "level": "error", "msg": reason}))
        self._ending = self._now()

    def abort(self, reason: str) -> None:
        """Cut the client off, and drop its pending data."""
        LOGGER.warning("%s: cut off: %s", self.name, reason)
        self._transport.abort()

    def _flush(self) -> None:
        self._server.dirty(self)
        self._server.flush()

    def _shake_hands(self, request: Request) -> None:
        response = self._answer(request)
        self._protocol.send_response(response)
        self._outbox.extend(self._protocol.data_to_send())  # before any message
        if self._protocol.state is not State.OPEN:
            LOGGER.warning("%s: refused: %s", self.name, response.reason_phrase)
            self._ending = self._now()
            return
        self._session = Session(self._server.hub, self.name, self._send)
        self._server.hub.counts.clients += 1
        LOGGER.info("%s: connected", self.name)
        self._server.tell_clients()

    def _answer(self, request: Request) -> Response:
        if not self._server.admits_client():
            text = f"the limit of {self._limits.clients} clients is reached\n"
            return self._protocol.reject(http.HTTPStatus.SERVICE_UNAVAILABLE, text)
        token = self._server.settings.token
        if token is not None and not _shows(request, token):
            text = "send the server's token: ws://HOST:PORT/?token=TOKEN\n"
            return self._protocol.reject(http.HTTPStatus.UNAUTHORIZED, text)
        return self._protocol.accept(request)

    def _take_message(self, message: Message) -> None:
        if self._session is None or self._ending is not None:
            return  # of a client that closes itself, all messages are processed
        try:
            text = message.content.decode()
        except UnicodeDecodeError as error:
            kind = "text" if message.is_text else "binary"
            self.close(CloseCode.INVALID_DATA, f"a {kind} frame is not UTF-8: {error.reason}")
            return
        self._session.receive(text)

    def _send(self, frames: bytes) -> None:
        if self._protocol.state is State.OPEN and self._ending is None:
            self._outbox.append(frames)
            self._server.dirty(self)

    def _count_held(self) -> None:
        """Refuse a client with too much queued data; report its size to the server."""
        n_bytes = self._transport.get_write_buffer_size()
        if n_bytes > self._limits.queue_bytes:
            self.refuse(
                f"too slow: {n_bytes} bytes are queued, the limit is {self._limits.queue_bytes}"
            )
        n_bytes += self._stream.n_bytes
        if self._session is not None:
            n_bytes += self._session.fragments.n_bytes
        self._server.hold(self, n_bytes if n_bytes > _FEW_BYTES else 0)


def _shows(request: Request, token: str) -> bool:
    """Return whether a client sends the token, in its URL or as bearer."""
    shown: list[Any] = list(parse_qs(urlsplit(request.path).query).get("token", ()))
    shown += [value.removeprefix("Bearer ") for value in request.headers.get_all("Authorization")]
    return any(hmac.compare_digest(value.encode(), token.encode()) for value in shown)


class BridgeServer:
    """A rosbridge server in the asyncio loop that runs when it is made.

    Settings that would open it to strangers are a ``SettingsError``.
    """

    def __init__(self, settings: ServerSettings) -> None:
        settings.check()
        self.settings = settings
        self._loop = asyncio.get_running_loop()
        self.hub = Hub(settings.types, settings.limits, self._loop)
        provide_rosapi(self.hub)
        self.url = ""
        self._server: asyncio.Server | None = None
        self._connections: dict[Connection, None] = {}
        self._dirty: dict[Connection, None] = {}
        self._held: dict[Connection, int] = {}
        self.buffer = memoryview(bytearray(_READ_BYTES))  # one for all reads
        self.n_held_bytes = 0  # held for and from clients with more than 64 KiB each
        self._checks: asyncio.TimerHandle | None = None
        self.barriers = Barriers(self._loop, lambda: self.hub.broker.is_idle)

    async def start(self) -> None:
        """Listen, or raise ``NotRunningError`` if the address cannot be bound."""
        host, port = self.settings.host, self.settings.port
        try:
            self._server = await self._loop.create_server(
                partial(Connection, self), host, port, backlog=512
            )
        except OSError as error:
            raise NotRunningError(
                f"{host}:{port}: cannot listen: {error.strerror}; choose another port"
            ) from error
        name = f"[{host}]" if ":" in host else host  # an address of IPv6
        self.url = f"ws://{name}:{self._server.sockets[0].getsockname()[1]}"
        self._checks = self._loop.call_later(_CHECKS_S, self._check)
        LOGGER.info("listening on %s", self.url)

    async def close(self) -> None:
        """Close all connections, and cut off clients that take too long."""
        if self._server is None:
            return
        self._server.close()
        if self._checks is not None:
            self._checks.cancel()
        for connection in tuple(self._connections):
            connection.close(CloseCode.GOING_AWAY, "the server shuts down")
        self.flush()
        end = self._loop.time() + 1.0
        while self._connections and self._loop.time() < end:
            await asyncio.sleep(0.01)
        for connection in tuple(self._connections):
            connection.abort("did not close")
        await asyncio.sleep(0)
        self._server = None

    def enter(self, connection: Connection) -> bool:
        """Accept a new socket; return whether there is room for its handshake."""
        if len(self._connections) >= self.settings.limits.clients + _SHAKING:
            return False
        self._connections[connection] = None
        return True

    def admits_client(self) -> bool:
        """Return whether there is room for another client."""
        n_clients = sum(connection.is_client for connection in self._connections)
        return n_clients < self.settings.limits.clients

    def dirty(self, connection: Connection) -> None:
        """Note that a connection has pending data; it is written before the loop continues."""
        if not self._dirty:
            self._loop.call_soon(self.flush)
        self._dirty[connection] = None

    def flush(self) -> None:
        """Write the pending data of all connections."""
        while self._dirty:
            connections, self._dirty = self._dirty, {}
            for connection in connections:
                connection.write()

    def hold(self, connection: Connection, n_bytes: int) -> None:
        """Note the bytes held for a client; beyond the limit of all, cut off the largest."""
        self.n_held_bytes += n_bytes - self._held.pop(connection, 0)
        if n_bytes:
            self._held[connection] = n_bytes
        if self.n_held_bytes > self.settings.limits.total_bytes:
            largest = max(self._held, key=self._held.__getitem__)
            largest.abort(
                f"{self.n_held_bytes} bytes are held for all clients, most of them for this one"
            )
            self.n_held_bytes -= self._held.pop(largest)

    def gone(self, connection: Connection) -> None:
        """Forget a connection."""
        self._connections.pop(connection, None)
        self.barriers.gone(connection)
        self._dirty.pop(connection, None)
        self.n_held_bytes -= self._held.pop(connection, 0)

    def barrier(self, then: Callable[[], None]) -> None:
        """Call a function when all clients have answered everything sent to them until now."""
        self.barriers.begin(lambda: [each for each in self._connections if each.is_client], then)

    def tell_clients(self) -> None:
        """Publish the connected clients."""
        tell_clients(self.hub, [each.details for each in self._connections if each.is_client])

    def _check(self) -> None:
        now = self._loop.time()
        for connection in tuple(self._connections):
            connection.check(now)
        self._checks = self._loop.call_later(_CHECKS_S, self._check)
