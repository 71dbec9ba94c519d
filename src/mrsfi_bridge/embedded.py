"""Two ways to run a server: in a thread of this process, or as a process until a signal.

An ``EmbeddedBridge`` runs a ``BridgeServer`` in a separate thread. Its ``hub`` is for clients
without a socket; it is used only in the server's thread, through ``call_soon``. The first error
raised there is kept in ``failed``.

The command line runs ``serve``: it prints the URL, writes the log, and ends on SIGTERM or
Ctrl-C.
"""

import asyncio
import logging
import signal
import sys
import threading
from collections.abc import Callable
from contextlib import suppress
from dataclasses import astuple
from typing import Any, Self

import click

from mrsfi_bridge.errors import NotRunningError
from mrsfi_bridge.server import BridgeServer
from mrsfi_bridge.session import LOGGER, Hub
from mrsfi_bridge.settings import ServerSettings


class EmbeddedBridge:
    """A rosbridge server in a separate thread, by default on any free port of this machine.

    ``ros`` is the version of ROS that it emulates, ``url`` its address once it has
    started, ``failed`` the first error in the server's thread.
    """

    def __init__(self, settings: ServerSettings | None = None) -> None:
        self._settings = settings or ServerSettings()
        self.ros = self._settings.types.ros
        self._loop: asyncio.AbstractEventLoop | None = None
        self._server: BridgeServer | None = None
        self._stop: asyncio.Event | None = None
        self._ready = threading.Event()
        self._thread = threading.Thread(target=self._run, name="mrsfi-bridge", daemon=True)
        self.url = ""
        self.failed: BaseException | None = None

    def start(self) -> None:
        """Start the thread; return once the server listens.

        It is a ``NotRunningError`` if the address cannot be bound, a ``SettingsError`` if the
        settings would open the server to strangers.
        """
        self._thread.start()
        self._ready.wait()
        if self._server is None and self.failed is not None:
            self._thread.join()
            raise self.failed

    @property
    def hub(self) -> Hub:
        """What all clients share; ``NotRunningError`` if the server does not run."""
        if self._server is None:
            raise NotRunningError("the embedded server does not run; start it first")
        return self._server.hub

    def call_soon(self, function: Callable[[], None]) -> None:
        """Call a function in the server's thread; its error is kept in ``failed``."""
        if self._loop is None:
            raise NotRunningError("the embedded server does not run")
        try:
            self._loop.call_soon_threadsafe(self._call, function)
        except RuntimeError as error:
            raise NotRunningError(f"the embedded server ended: {self.failed}") from error

    def call_later(self, seconds: float, function: Callable[[], None]) -> None:
        """Call a function in the server's thread after a time; call this in that thread."""
        if self._loop is not None:
            self._loop.call_later(seconds, self._call, function)

    def barrier(self, then: Callable[[], None]) -> None:
        """Call a function when all clients have answered everything sent to them until now.

        This holds for clients that process messages in one thread. Call this in the
        server's thread, in which the function is called, too.
        """
        if self._server is not None:
            self._server.barrier(lambda: self._call(then))

    def close(self) -> None:
        """End the server and its thread; a second call does nothing."""
        loop, stop = self._loop, self._stop
        if loop is not None and stop is not None:
            self._loop = None
            with suppress(RuntimeError):  # it ended by itself
                loop.call_soon_threadsafe(stop.set)
            self._thread.join(10.0)

    def __enter__(self) -> Self:
        self.start()
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _run(self) -> None:
        try:
            asyncio.run(self._serve())
        except BaseException as error:  # noqa: BLE001 - raised in the thread that waits
            self.failed = self.failed or error
            self._ready.set()

    async def _serve(self) -> None:
        loop = asyncio.get_running_loop()
        loop.set_exception_handler(self._note)
        server = BridgeServer(self._settings)
        await server.start()
        self._stop = asyncio.Event()
        self._server, self._loop, self.url = server, loop, server.url
        self._ready.set()
        try:
            await self._stop.wait()
        finally:
            self._server = None
            await server.close()

    def _call(self, function: Callable[[], None]) -> None:
        try:
            function()
        except Exception as error:  # noqa: BLE001 - who called it has its own way to hear of it
            self.failed = self.failed or error
        if self._server is not None:
            self._server.flush()

    def _note(self, loop: asyncio.AbstractEventLoop, context: dict[str, Any]) -> None:
        """Keep an error that asyncio could not raise."""
        loop.default_exception_handler(context)
        error = context.get("exception") or RuntimeError(str(context.get("message")))
        self.failed = self.failed or error


def serve(settings: ServerSettings) -> None:
    """Run a server until SIGTERM or Ctrl-C; print its URL to standard output.

    It is a ``SettingsError`` if the settings would open the server to strangers or a definition
    is wrong, a ``NotRunningError`` if the address cannot be bound.
    """
    settings.check()
    settings.types.check()
    logging.basicConfig(
        stream=sys.stderr, level=logging.INFO, format="%(asctime)s %(levelname)s %(message)s"
    )
    asyncio.run(_serve(settings))


async def _serve(settings: ServerSettings) -> None:
    server = BridgeServer(settings)
    await server.start()
    click.echo(server.url)
    sys.stdout.flush()
    ended = asyncio.Event()
    with suppress(NotImplementedError):  # Windows has no handlers, and ends the process itself
        asyncio.get_running_loop().add_signal_handler(signal.SIGTERM, ended.set)
    try:
        await ended.wait()
    finally:
        await server.close()
        LOGGER.info(
            "ended: %d clients, %d operations received, %d messages sent, %d dropped",
            *astuple(server.hub.counts),
        )
