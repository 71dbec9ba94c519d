"""The engine over rosbridge: simulation and CI as two processes on a server.

They exchange only the ROS messages of the mission's topics, in lock-step. Results are those of
the reference engine, bit for bit.

``serve_simulation`` is the simulation's side, in this process. ``SimulationProcess`` runs it in
another one, ``python -m mrsfi_runtime.engine.rosbridge``. That process receives its mission over a
connection, reports that it is ready or why not, and ends when the connection closes, for any
reason. ``RosbridgeEngine`` is the CI's side.

References
----------
Source paper, sections III-F and III-G.
"""

import sys
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import astuple
from multiprocessing.connection import Connection
from subprocess import DEVNULL, TimeoutExpired
from threading import Thread

from mrsfi_bridge.settings import TypeTable
from mrsfi_runtime.cosimulation.bus_lockstep import SimulationHost
from mrsfi_runtime.cosimulation.bus_topics import GO_BUNDLE, BundlingTransport, Patience
from mrsfi_runtime.cosimulation.lockstep import Flight
from mrsfi_runtime.cosimulation.programs import child_of, ending
from mrsfi_runtime.engine.external import ExternalEngine, at_server, joined
from mrsfi_runtime.errors import (
    MrsfiError,
    TransportClosed,
    TransportError,
    TransportTimeout,
    UsageError,
)
from mrsfi_runtime.generated_code import MissionCode, load_code
from mrsfi_runtime.record.engine_settings import BOTH, EngineSettings
from mrsfi_runtime.transport.rosbridge import EmbeddedTransport, RosbridgeTransport, errors_as_ours
from mrsfi_runtime.transport.topics import PrefixedTransport, Transport

_LATER = 5.0  # seconds


def serve_simulation(
    code: MissionCode,
    settings: EngineSettings,
    on_ready: Callable[[str, SimulationHost], None],
    tell: Callable[[str], None] = lambda _: None,
) -> None:
    """Serve the simulation of a mission until it is stopped, on the settings' server or its own.

    It waits 5 s longer than their patience for the other side, which knows more about a silence and
    reports first; ``tell`` receives which run ended so. ``on_ready`` receives the server's URL, and
    the host, to stop it. Lost messages are a TransportError.
    """
    patience = Patience(*(each + _LATER for each in astuple(settings.patience)))
    with _transport(settings) as (transport, reached):
        bundling = BundlingTransport(transport, is_ci=False)
        host = SimulationHost(bundling, code.simulation, code.mission, patience, tell)
        on_ready(reached, host)
        try:
            host.serve()
        except TransportError as error:
            raise type(error)(f"{host.where()}: {error}") from error


@contextmanager
def _transport(settings: EngineSettings) -> Iterator[tuple[Transport, str]]:
    """Yield a transport and the URL of its server."""
    with errors_as_ours(), ExitStack() as opened:
        if settings.url is None:
            yield joined(settings, TypeTable(ros=settings.ros), opened)
        else:
            server = at_server(settings.url, settings, opened)
            yield PrefixedTransport(server, settings.world_prefix), settings.url


def main(number: int) -> None:
    """Serve the mission that a connection's first message names; report there an early end."""
    connection = Connection(number)
    directory, settings = connection.recv()

    def on_ready(reached: str, host: SimulationHost) -> None:
        Thread(target=_stop_with_parent, args=(connection, host), daemon=True).start()
        _send(connection, url=reached)

    try:
        serve_simulation(load_code(directory), settings, on_ready)
    except MrsfiError as error:
        _send(connection, error=str(error))
    except BaseException as error:  # noqa: BLE001 - the parent reports it
        _send(connection, error=f"{type(error).__name__}: {error}")


def _stop_with_parent(connection: Connection, host: SimulationHost) -> None:
    with suppress(EOFError, OSError):
        connection.recv()  # nothing more comes; it returns when the parent ends
    host.stop()


def _send(connection: Connection, **message: str) -> None:
    with suppress(BrokenPipeError):
        connection.send(message)


_LAST_WORDS = 2.0  # seconds for a process to end


class SimulationProcess:
    """The simulation of a mission in a process of its own, which dies with this one.

    It joins the server that the settings name, or embeds one if they name none; their patience is
    how long to wait for it. ``url`` is the URL of its server, with the token if one is needed. If
    it cannot serve, that is a TransportError.
    """

    def __init__(self, code: MissionCode, settings: EngineSettings) -> None:
        patience = settings.patience
        self._process, self._connection = child_of(__name__, stdout=DEVNULL)
        with suppress(BrokenPipeError):  # its message, or how it ended, explains why
            # a URL may hold a token, so it is no argument
            self._connection.send((code.directory.resolve(), settings))
        message = self._received(patience.handshake)
        if "url" not in message:
            reason = message.get("error") or ending(self._process, _LAST_WORDS)
            raise TransportError(f"the simulation process did not start: {reason}")
        self.url, self.pid = message["url"], self._process.pid

    def wait(self) -> None:
        """Return when the process has ended."""
        self._process.wait()

    def last_words(self) -> str:
        """Return why the process ended; empty if it has not."""
        try:
            self._process.wait(_LAST_WORDS)
        except TimeoutExpired:
            return ""
        return self._received().get("error") or ending(self._process, _LAST_WORDS)

    def close(self) -> None:
        """End the process, and wait until it has ended."""
        self._connection.close()
        ending(self._process, _LAST_WORDS)

    def _received(self, timeout: float = 0.0) -> dict[str, str]:
        """Return the next message of the process; empty if none comes."""
        message: dict[str, str] = {}
        with suppress(EOFError, OSError):
            message = self._connection.recv() if self._connection.poll(timeout) else message
        return message


class RosbridgeEngine(ExternalEngine):
    """Flies missions over a rosbridge server, one connection for many evaluations.

    The simulation is the built-in one, in a process of its own, or an external one. A seed is at
    most 2**63 - 1. A server or a simulation that cannot be reached is a TransportError; settings
    that contradict each other are a UsageError.
    """

    def __init__(self, code: MissionCode, seed: int, settings: EngineSettings) -> None:
        super().__init__(code, seed, settings)
        patience = settings.patience
        _require_seed(seed)
        self.patience = 2 * (patience.tick + patience.handshake)
        self.simulation: SimulationProcess | None = None
        with ExitStack() as opened:
            with errors_as_ours():
                self._transport = self._join(opened)
            self._opened = opened.pop_all()
        self._may_ignore_bundles = settings.is_bundled and settings.side != BOTH
        world = PrefixedTransport(self._transport, settings.world_prefix)
        self.lock_step_with(self.bundled(world))
        if self.simulation is not None:
            Thread(target=self._watch, args=(self.simulation,), daemon=True).start()

    def _join(self, opened: ExitStack) -> EmbeddedTransport | RosbridgeTransport:
        """Return the transport of the simulation, after starting it if it is started here."""
        settings, url = self.settings, self.settings.url
        if settings.world_command is not None:
            return self.started_world(opened)
        # first: it explains best what is wrong with the URL
        found = None if url is None else at_server(url, settings, opened)
        if settings.side == BOTH:
            self.simulation = SimulationProcess(self.code, settings)
            opened.callback(self.simulation.close)
            found = found or at_server(self.simulation.url, settings, opened)
        assert found is not None  # the settings made sense
        return found

    def _watch(self, simulation: SimulationProcess) -> None:
        """Stop waiting for a simulation that has ended; its server would only be silent."""
        simulation.wait()
        self._transport.report(TransportClosed("the simulation no longer runs"))

    def _fly(self, flight: Flight, seed: int) -> None:
        _require_seed(seed)
        try:
            super()._fly(flight, seed)
        except TransportTimeout as error:
            if not self._may_ignore_bundles or self._lockstep.tick:
                raise
            raise TransportTimeout(
                f"{error}; --bundle expects it to know {GO_BUNDLE.name}; if not, omit --bundle"
            ) from error
        except TransportClosed as error:
            last_words = self.simulation.last_words() if self.simulation else ""
            if not last_words:
                raise
            raise TransportClosed(f"{error}; the simulation process ended: {last_words}") from error


def _require_seed(seed: int) -> None:
    if seed >= 2**63:
        raise UsageError(
            f"mission seed {seed}: too large for a ROS message; expected at most 2^63 - 1"
        )


if __name__ == "__main__":
    main(int(sys.argv[1]))
