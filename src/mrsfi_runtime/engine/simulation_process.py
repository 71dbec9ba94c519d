"""The simulation's side of a mission: served in this process, or as a process of its own.

Run as ``python -m mrsfi_runtime.engine.simulation_process`` it finds a connection to the process
that started it, says there when it is ready and why it fails, and ends when the other end of the
connection does, however its process came to that.
"""

import secrets
import sys
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager, suppress
from multiprocessing.connection import Connection
from threading import Thread

from mrsfi_bridge.embedded import EmbeddedBridge
from mrsfi_bridge.errors import BridgeError
from mrsfi_bridge.settings import ServerSettings, TypeTable
from mrsfi_runtime.cosimulation.bus_lockstep import SimulationHost
from mrsfi_runtime.cosimulation.bus_topics import BundlingTransport
from mrsfi_runtime.errors import MrsfiError, TransportError
from mrsfi_runtime.generated_code import MissionCode, load_code
from mrsfi_runtime.record.engine_settings import EngineSettings
from mrsfi_runtime.transport.rosbridge import EmbeddedTransport, RosbridgeTransport, as_ours
from mrsfi_runtime.transport.topics import PrefixedTransport, Transport


def serve_simulation(
    code: MissionCode,
    settings: EngineSettings,
    on_ready: Callable[[str, SimulationHost], None],
) -> None:
    """Serve the simulation of a mission until it is stopped, on the settings' server or its own.

    Their patience is how long the collective intelligence may be silent in mid-run; ``on_ready`` is
    told the server's URL, and the host that it may stop. Lost messages are a TransportError.
    """
    with _transport(settings) as (transport, reached):
        bundling = BundlingTransport.of_simulation(transport)
        host = SimulationHost(bundling, code.simulation, code.mission, settings.patience)
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
def _transport(settings: EngineSettings) -> Iterator[tuple[Transport, str]]:
    """Yield a transport and the URL of its server."""
    url, ros = settings.url, settings.ros
    if url is not None:
        with closing(RosbridgeTransport(url, settings.client, ros)) as joined:
            yield PrefixedTransport(joined, settings.world_prefix), url
        return
    token = secrets.token_urlsafe()  # other users of this machine are no part of the mission
    try:
        with (
            EmbeddedBridge(ServerSettings(token=token, types=TypeTable(ros=ros))) as bridge,
            closing(EmbeddedTransport(bridge)) as embedded,
        ):
            yield embedded, f"{bridge.url}/?token={token}"
    except BridgeError as error:
        raise as_ours(error) from error


def main(number: int) -> None:
    """Serve what the first message on a connection asks for; say there why that ended early."""
    connection = Connection(number)
    directory, settings = connection.recv()

    def on_ready(reached: str, host: SimulationHost) -> None:
        Thread(target=_stop_with_parent, args=(connection, host), daemon=True).start()
        _say(connection, url=reached)

    try:
        serve_simulation(load_code(directory), settings, on_ready)
    except MrsfiError as error:
        _say(connection, error=str(error))
    except BaseException as error:  # noqa: BLE001 - the parent tells it
        _say(connection, error=f"{type(error).__name__}: {error}")


def _stop_with_parent(connection: Connection, host: SimulationHost) -> None:
    with suppress(EOFError, OSError):
        connection.recv()  # the parent says nothing more; its end ends this
    host.stop()


def _say(connection: Connection, **said: str) -> None:
    with suppress(BrokenPipeError):
        connection.send(said)


if __name__ == "__main__":
    main(int(sys.argv[1]))
