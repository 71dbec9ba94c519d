"""The server: listens, keeps its clients within their limits, and shares out what they send."""

import asyncio
from functools import partial

from websockets.frames import CloseCode

from mrsfi_bridge.connection import Connection
from mrsfi_bridge.errors import ListenError
from mrsfi_bridge.rosapi import provide_rosapi
from mrsfi_bridge.session import LOGGER, Hub
from mrsfi_bridge.settings import ServerSettings

_BACKLOG = 512
_CHECKS_S = 0.25
_SHAKING = 256
"""Sockets beside those of clients: shaking hands, refused, or closing."""


class BridgeServer:
    """A rosbridge server in the asyncio loop that runs when it is made.

    Parameters
    ----------
    settings
        Address, access, limits.

    Raises
    ------
    SettingsError
        If the settings would open the server to strangers.
    """

    def __init__(self, settings: ServerSettings) -> None:
        settings.check()
        self.settings = settings
        self._loop = asyncio.get_running_loop()
        self.hub = Hub(settings.types, settings.limits, self._loop)
        provide_rosapi(self.hub)
        self.url = ""
        self._server: asyncio.Server | None = None
        self._connections: set[Connection] = set()
        self._dirty: dict[Connection, None] = {}
        self._held: dict[Connection, int] = {}
        self.n_held_bytes = 0  # wait for and from clients, but for less than 64 KiB of each
        self._checks: asyncio.TimerHandle | None = None

    async def start(self) -> None:
        """Listen.

        Raises
        ------
        ListenError
            If the address cannot be bound.
        """
        host, port = self.settings.host, self.settings.port
        try:
            self._server = await self._loop.create_server(
                partial(Connection, self), host, port, backlog=_BACKLOG
            )
        except OSError as error:
            raise ListenError(
                f"{host}:{port}: cannot listen: {error.strerror}; choose another port"
            ) from error
        name = f"[{host}]" if ":" in host else host  # an address of IPv6
        self.url = f"ws://{name}:{self._server.sockets[0].getsockname()[1]}"
        self._checks = self._loop.call_later(_CHECKS_S, self._check)
        LOGGER.info("listening on %s", self.url)

    async def close(self) -> None:
        """Take leave of all clients, and cut off those that take too long."""
        if self._server is None:
            return
        self._server.close()
        if self._checks is not None:
            self._checks.cancel()
        for connection in tuple(self._connections):
            connection.close(CloseCode.GOING_AWAY, "the server ends")
        self.flush()
        end = self._loop.time() + 1.0
        while self._connections and self._loop.time() < end:
            await asyncio.sleep(0.01)
        for connection in tuple(self._connections):
            connection.abort("did not close")
        await asyncio.sleep(0)
        self._server = None

    # What connections call.

    def enter(self, connection: Connection) -> bool:
        """Take a new socket in; return whether there is room for it to shake hands."""
        if len(self._connections) >= self.settings.limits.clients + _SHAKING:
            return False
        self._connections.add(connection)
        return True

    def admits_client(self) -> bool:
        """Return whether there is room for another client."""
        n_clients = sum(connection.is_client for connection in self._connections)
        return n_clients < self.settings.limits.clients

    def dirty(self, connection: Connection) -> None:
        """Note that a connection has something to write; it will before the loop goes on."""
        if not self._dirty:
            self._loop.call_soon(self.flush)
        self._dirty[connection] = None

    def flush(self) -> None:
        """Have all connections write what they have."""
        while self._dirty:
            connections, self._dirty = self._dirty, {}
            for connection in connections:
                connection.write()

    def hold(self, connection: Connection, n_bytes: int) -> None:
        """Note what waits for and from a client; beyond the limit of all, who has most goes."""
        self.n_held_bytes += n_bytes - self._held.pop(connection, 0)
        if n_bytes:
            self._held[connection] = n_bytes
        if self.n_held_bytes > self.settings.limits.total_bytes:
            largest = max(self._held, key=self._held.__getitem__)
            largest.abort(
                f"{self.n_held_bytes} bytes wait for and from all clients, most of them here"
            )
            self.n_held_bytes -= self._held.pop(largest)

    def gone(self, connection: Connection) -> None:
        """Forget a connection."""
        self._connections.discard(connection)
        self._dirty.pop(connection, None)
        self.n_held_bytes -= self._held.pop(connection, 0)

    def _check(self) -> None:
        now = self._loop.time()
        for connection in tuple(self._connections):
            connection.check(now)
        self._checks = self._loop.call_later(_CHECKS_S, self._check)
