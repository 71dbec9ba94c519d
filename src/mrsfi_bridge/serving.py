"""A server that runs until its process is told to end: log and signals."""

import asyncio
import logging
import signal
import sys
from contextlib import suppress

import click

from mrsfi_bridge.server import BridgeServer
from mrsfi_bridge.session import LOGGER
from mrsfi_bridge.settings import ServerSettings


def serve(settings: ServerSettings) -> None:
    """Run a server until the process is told to end; its URL goes to standard output.

    It is a ``SettingsError`` if the settings would open the server to strangers or a definition
    is wrong, a ``ListenError`` if the address cannot be bound.
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
        counts = server.hub.counts
        LOGGER.info(
            "ended: %d clients, %d operations received, %d messages sent, %d dropped",
            counts.clients,
            counts.received,
            counts.sent,
            counts.dropped,
        )
