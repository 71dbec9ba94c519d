"""The engine for an external node as the collective intelligence, with faults in its messages.

The node receives the faulty reports on topics of its own, and the engine flies its commands. Either
the built-in simulation runs in this process, and the node joins an embedded server; or the
simulation is external, and simulation, injector and node are on one server.

A keeper process starts and ends the node: run as ``python -m mrsfi_runtime.engine.injector``,
``Keeper`` reads from a connection which node to start or end, and reports how nodes ended. When the
connection closes, for any reason, the keeper ends the node and all processes that it started.
``NodeProcess`` is the engine's side of it. Begin with ``InjectorEngine``, at the end.
"""

import os
import secrets
import shlex
import signal
import sys
from collections import deque
from contextlib import ExitStack, suppress
from multiprocessing import Pipe
from multiprocessing.connection import Connection, wait
from subprocess import DEVNULL, PIPE, STDOUT, Popen, TimeoutExpired
from threading import Thread
from typing import TYPE_CHECKING

from mrsfi_bridge.embedded import EmbeddedBridge
from mrsfi_bridge.errors import BridgeError
from mrsfi_bridge.settings import Limits, ServerSettings, TypeTable
from mrsfi_runtime.cosimulation.bus_lockstep import BusLockstep, SimulationHost
from mrsfi_runtime.cosimulation.bus_topics import BundlingTransport, Pace
from mrsfi_runtime.cosimulation.lockstep import Flight
from mrsfi_runtime.cosimulation.node import Node
from mrsfi_runtime.cosimulation.node_speech import Speech, held_commands, out_of_reach
from mrsfi_runtime.engine.flights import PlainEngine, Request
from mrsfi_runtime.errors import (
    EvaluationError,
    SpecificationError,
    TransportClosed,
    TransportError,
    UsageError,
)
from mrsfi_runtime.generated_code import MissionCode
from mrsfi_runtime.model.mission import Outcome
from mrsfi_runtime.record.engine_settings import RESTART, EngineSettings
from mrsfi_runtime.transport.rosbridge import EmbeddedTransport, RosbridgeTransport, as_ours
from mrsfi_runtime.transport.topics import LocalBus, PrefixedTransport

if TYPE_CHECKING:
    from mrsfi_runtime.transport.topics import Transport


_GRACE = 1.0
"""Seconds that a node has to end after a signal."""


class _Child:
    """A node that was started, and the last lines that it wrote."""

    def __init__(self, words: list[str]) -> None:
        self.process = Popen(
            words, stdin=DEVNULL, stdout=PIPE, stderr=STDOUT, start_new_session=True
        )
        self._lines: deque[bytes] = deque(maxlen=5)
        self._reader = Thread(target=self._read, daemon=True)
        self._reader.start()

    def _read(self) -> None:
        assert self.process.stdout is not None
        for line in self.process.stdout:
            self._lines.append(line[:500])

    def end(self) -> None:
        """End the node and all processes that it started."""
        for number in (signal.SIGTERM, signal.SIGKILL):
            with suppress(ProcessLookupError, PermissionError):
                os.killpg(self.process.pid, number)
            with suppress(TimeoutExpired):
                self.process.wait(_GRACE)

    def last_words(self) -> str:
        """Return how it ended, and what it wrote last."""
        self._reader.join(_GRACE)
        code = self.process.returncode
        how = f"signal {signal.Signals(-code).name}" if code < 0 else f"exit code {code}"
        lines = [line.decode(errors="replace").strip() for line in self._lines]
        output = " / ".join(line for line in lines if line)
        return f"{how}{': ' if output else ''}{output}"


class Keeper:
    """Starts and ends nodes, one at a time, as a connection requests."""

    def __init__(self, connection: Connection) -> None:
        self._connection = connection
        self._child: _Child | None = None

    def serve(self) -> None:
        """Start each command received, or only end the node if it is empty; until disconnected."""
        with suppress(EOFError, OSError):
            while True:
                child = self._child
                if child is not None and child.process.poll() is not None:
                    self._end()  # the processes that it started, too
                    self._connection.send(("ended", child.last_words()))
                if wait([self._connection], None if self._child is None else 0.05):
                    self._change(self._connection.recv())
        self._end()

    def _change(self, words: list[str]) -> None:
        self._end()
        try:
            self._child = _Child(words) if words else None
        except OSError as error:
            self._connection.send(("failed", f"{words[0]}: {error.strerror}"))
            return
        self._connection.send(("done", str(self._child.process.pid) if self._child else ""))

    def _end(self) -> None:
        child, self._child = self._child, None
        if child is not None:
            child.end()


class NodeProcess:
    """A node that dies with this process; ``pid`` is that of the last one that was started.

    In ``command``, ``{url}``, ``{host}``, ``{port}`` and ``{seed}`` are replaced by the place of
    the server and the mission seed. An invalid command is a ``UsageError``.
    """

    def __init__(self, command: str, url: str) -> None:
        try:
            self._words = shlex.split(command)
        except ValueError as error:
            raise UsageError(f"--node: found {command!r}: {error}; expected a command") from error
        if not self._words:
            raise UsageError("--node: found nothing; expected a command")
        self._url = url
        self.pid = 0
        self._connection, other_end = Pipe()
        with other_end:
            self._keeper = Popen(
                [sys.executable, "-m", __name__, str(other_end.fileno())],
                pass_fds=[other_end.fileno()],
                stdin=DEVNULL,
                start_new_session=True,  # Ctrl-C reaches this process only, which ends that one
            )

    def start(self, seed: int) -> None:
        """End the node if it runs, and start it for a mission seed."""
        address = self._url.partition("://")[2].partition("/")[0]
        host, _, port = address.rpartition(":")
        filled = {"{url}": self._url, "{host}": host, "{port}": port, "{seed}": str(seed)}
        words = []
        for word in self._words:
            for name, value in filled.items():
                word = word.replace(name, value)  # noqa: PLW2901 - one after the other
            words.append(word)
        self._request(words)

    def stop(self) -> None:
        """End the node if it runs."""
        self._request([])

    def ended(self) -> str:
        """Return how the node ended and what it wrote last, or nothing while it runs."""
        with suppress(EOFError, OSError):
            if self._connection.poll():
                _, ending = self._connection.recv()
                self.pid = 0
                return str(ending)
        return ""

    def close(self) -> None:
        """End the node, and wait for that."""
        self._connection.close()
        try:
            self._keeper.wait(4.0)
        except TimeoutExpired:
            self._keeper.kill()
            self._keeper.wait()

    def _request(self, words: list[str]) -> None:
        """Have the keeper start a command, or only end the node if the command is empty."""
        try:
            self._connection.send(words)
            kind, answer = "ended", ""
            while kind == "ended":  # about the previous node
                kind, answer = self._connection.recv()
        except (EOFError, OSError) as error:
            raise TransportClosed("the process that supervises the node has ended") from error
        if kind == "failed":
            raise TransportError(f"the node did not start: {answer}; check --node")
        self.pid = int(answer or 0)


class InjectorEngine(PlainEngine):
    """Flies missions with an external node as the collective intelligence.

    If a node that is started here fails twice under a specification, that is an
    ``EvaluationError`` of the specification. Every other problem is a ``TransportError``.
    """

    def __init__(self, code: MissionCode, seed: int, settings: EngineSettings) -> None:
        super().__init__(code, seed)
        self._settings, patience = settings, settings.patience
        self.patience = 4 * (patience.tick + patience.handshake)
        speech = Speech.of(settings.node_mapping, code.mission, settings.ros)
        with ExitStack() as opened:
            try:
                transport = self._join(speech.types, opened)
            except BridgeError as error:
                raise as_ours(error) from error
            self._process: NodeProcess | None = None
            if settings.node is not None:
                self._process = NodeProcess(settings.node, self._url)
                opened.callback(self._process.close)
            embedded = self._embedded
            pace = Pace(settings.node_pace, embedded.barrier if embedded else None)
            is_restarted = settings.node_reset == RESTART
            self.node = Node(
                transport, speech, pace, patience, self._process, restarts=is_restarted
            )
            self._lockstep = BusLockstep(
                self._world, code.mission, code.interface, code.truth, patience, self.node
            )
            transport.watch(self._lockstep.fail)
            if embedded is not None:
                embedded.on_refusal(
                    lambda topic, why: self.node.refuse(transport.unnamed(topic), why)
                )
            for each in speech.relayed:
                if settings.url is None:
                    raise UsageError(
                        f"[node] {each.topic.name}: is passed on to the simulation, but the "
                        f"built-in one has no {each.world.name}; expected --url, or fields"
                    )
            self.node.pass_on(self._lockstep.advertise)
            self._opened = opened.pop_all()
        self.interface = self._lockstep.interface

    def close(self) -> None:
        """End the node and the connection."""
        self._opened.close()

    def _join(self, types: TypeTable, opened: ExitStack) -> PrefixedTransport:
        """Create the transport of the simulation; return the transport of the node."""
        settings, code = self._settings, self.code
        self._embedded: EmbeddedTransport | None = None
        if settings.url is not None:
            joined = RosbridgeTransport(settings.url, settings.client, settings.ros)
            opened.callback(joined.close)
            self._url = settings.url
            world = PrefixedTransport(joined, settings.world_prefix)
            self._world: Transport = world
            if settings.is_bundled:
                self._world = BundlingTransport.of_ci(world)
            return PrefixedTransport(joined, settings.node_prefix)
        # the token keeps out other users of this machine
        token = secrets.token_urlsafe() if "{url}" in (settings.node or "") else None
        limits = Limits(service_s=2 * settings.patience.handshake)  # the engine reports first
        server = ServerSettings(token=token, types=types, limits=limits)
        bridge = opened.enter_context(EmbeddedBridge(server))
        self._url = bridge.url if token is None else f"{bridge.url}/?token={token}"
        embedded = self._embedded = EmbeddedTransport(bridge)
        opened.callback(embedded.close)
        self._world = LocalBus()
        self._host = SimulationHost(self._world, code.simulation, code.mission, settings.patience)
        return PrefixedTransport(embedded, settings.node_prefix)

    def _evaluate(self, request: Request) -> Outcome:
        beyond = out_of_reach(self.code.mission, request.pool, self.node.speech)
        for timed in request.specification:
            if timed.fault in beyond:
                raise SpecificationError(
                    f"fault '{timed.fault}' cannot be injected: it affects {beyond[timed.fault]}, "
                    "and no topic carries that to the node; map one in [node] of mrsfi.toml, or "
                    "leave the fault out (docs/node.md)",
                    (timed.fault,),
                )
        held = held_commands(self.code.mission, request.pool, request.specification)
        self.node.held = [*held]
        flights = [self._flown_well(request)]
        while len(flights) < self._settings.node_repeats:
            flights.append(self._flown_well(request._replace(observer=None, tallies=[])))
        flights.sort(key=lambda each: (sum(each.believed), sum(each.true), each.digest))
        return flights[len(flights) // 2]

    def _flown_well(self, request: Request) -> Outcome:
        """Fly; if the node fails twice, that is an error of the specification."""
        for is_last in (request.observer is not None, True):
            try:
                return super()._evaluate(request)
            except TransportError as error:
                if self._process is None or not self.node.is_to_blame:
                    raise
                self._process.stop()
                if is_last:
                    raise EvaluationError(str(error)) from error
        raise AssertionError

    def _fly(self, flight: Flight, seed: int) -> None:
        self._lockstep.fly(flight, seed)


if __name__ == "__main__":
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    Keeper(Connection(int(sys.argv[1]))).serve()
