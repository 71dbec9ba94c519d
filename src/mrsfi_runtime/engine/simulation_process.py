"""The simulation's side of a mission: served in this process, or as a process of its own.

Run as ``python -m mrsfi_runtime.engine.simulation_process`` it reads one line of JSON, prints
one when it is ready and another when it fails, and ends when its standard input does, however
the process that holds the other end came to its end.
"""

import json
import os
import secrets
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from threading import Thread

from mrsfi_bridge.embedded import EmbeddedBridge
from mrsfi_bridge.errors import BridgeError
from mrsfi_bridge.settings import ServerSettings
from mrsfi_runtime.errors import MrsfiError, TransportError
from mrsfi_runtime.hosting.bundle import BundlingTransport
from mrsfi_runtime.hosting.simulation_host import SimulationHost
from mrsfi_runtime.hosting.waiting import Patience
from mrsfi_runtime.mission import MissionCode, load_code
from mrsfi_runtime.transport.bridge_errors import as_ours
from mrsfi_runtime.transport.embedded import EmbeddedTransport
from mrsfi_runtime.transport.rosbridge import Client, RosbridgeTransport
from mrsfi_runtime.transport.topics import Transport

_LATER = 5.0


def serve_simulation(
    code: MissionCode,
    url: str | None,
    client: Client,
    patience: Patience,
    on_ready: Callable[[str, SimulationHost], None],
) -> None:
    """Serve the simulation of a mission until it is stopped.

    Parameters
    ----------
    code
        Generated code of the mission.
    url
        The rosbridge server to join; one is embedded if left out.
    client
        Kind of roslibpy's connection, for a server that is joined.
    patience
        How long the collective intelligence may be silent in mid-run.
    on_ready
        Told the server's URL, and the host that it may stop.

    Raises
    ------
    TransportError
        If messages were lost, the connection is gone, or the CI is silent in mid-run.
    """
    with _transport(url, client) as (transport, reached):
        bundling = BundlingTransport.of_simulation(transport)
        host = SimulationHost(bundling, code.simulation, code.mission, patience)
        on_ready(reached, host)
        try:
            host.serve()
        except Exception as error:
            where = host.where()
            with suppress(TransportError):
                host.tell_failure(error)
            if isinstance(error, TransportError):
                raise type(error)(f"{where}: {error}") from error
            raise


@contextmanager
def _transport(url: str | None, client: Client) -> Iterator[tuple[Transport, str]]:
    """Yield a transport and the URL of its server."""
    if url is not None:
        joined = RosbridgeTransport(url, client)
        try:
            yield joined, url
        finally:
            joined.close()
        return
    token = secrets.token_urlsafe()  # other users of this machine are no part of the mission
    try:
        with EmbeddedBridge(ServerSettings(token=token)) as bridge:
            embedded = EmbeddedTransport(bridge)
            try:
                yield embedded, f"{bridge.url}/?token={token}"
            finally:
                embedded.close()
    except BridgeError as error:
        raise as_ours(error) from error


def request(directory: Path, url: str | None, client: Client, patience: Patience) -> bytes:
    """Return the line that the process reads first; a URL may hold a token, so no argument."""
    patient = patience.tick + _LATER  # so that the CI, which knows more, is the first to tell
    return json.dumps([str(directory), url, client, patient]).encode() + b"\n"


def main() -> int:
    """Serve what the request says; return the exit code."""
    directory, url, client, tick = json.loads(_first_line())

    def on_ready(reached: str, host: SimulationHost) -> None:
        Thread(target=_stop_with_parent, args=(host,), daemon=True).start()
        _say(url=reached)

    try:
        serve_simulation(load_code(Path(directory)), url, client, Patience(tick), on_ready)
    except MrsfiError as error:
        _say(error=str(error))
        return error.exit_code
    except Exception as error:  # noqa: BLE001 - the parent tells it
        _say(error=f"{type(error).__name__}: {error}")
        return MrsfiError.exit_code
    return 0


def _first_line() -> bytes:
    line = b""
    while not line.endswith(b"\n"):
        line += os.read(sys.stdin.fileno(), 1) or b"\n"
    return line


def _stop_with_parent(host: SimulationHost) -> None:
    while os.read(sys.stdin.fileno(), 1024):  # not sys.stdin: its lock outlives a daemon thread
        pass
    host.stop()


def _say(**said: str) -> None:
    with suppress(BrokenPipeError):
        os.write(sys.stdout.fileno(), json.dumps(said).encode() + b"\n")


if __name__ == "__main__":
    sys.exit(main())
