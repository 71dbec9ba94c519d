"""Engines for external programs, a node or a simulation, which may be started here.

``joined`` embeds a server for such a program. An ``ExternalEngine`` restarts what failed, and flies
a specification several times if its programs do not repeat themselves. The ``InjectorEngine`` has
an external node as the collective intelligence: the node receives the faulty reports on topics of
its own, and the engine flies its commands.
"""

import secrets
import shlex
from collections.abc import Mapping
from contextlib import ExitStack
from dataclasses import replace
from typing import TYPE_CHECKING

from mrsfi_bridge.embedded import EmbeddedBridge
from mrsfi_bridge.settings import Limits, ServerSettings, TypeTable
from mrsfi_runtime.cosimulation.bus_lockstep import BusLockstep, SimulationHost
from mrsfi_runtime.cosimulation.bus_topics import BundlingTransport, Pace
from mrsfi_runtime.cosimulation.lockstep import Flight, Mind
from mrsfi_runtime.cosimulation.node import Node
from mrsfi_runtime.cosimulation.node_speech import Speech, held_commands, out_of_reach
from mrsfi_runtime.cosimulation.programs import NODE, WORLD, KeptProcess, Places, places_of
from mrsfi_runtime.engine.flights import PlainEngine, Request
from mrsfi_runtime.errors import EvaluationError, SpecificationError, TransportError, UsageError
from mrsfi_runtime.generated_code import MissionCode
from mrsfi_runtime.model.faults import Specification
from mrsfi_runtime.model.mission import Outcome, Repetition
from mrsfi_runtime.record.engine_settings import RESTART, ROS2, EngineSettings
from mrsfi_runtime.transport.rosbridge import EmbeddedTransport, RosbridgeTransport, errors_as_ours
from mrsfi_runtime.transport.topics import LocalBus, PrefixedTransport, TopicQos, Transport

if TYPE_CHECKING:
    from mrsfi_runtime.engine.recording import Recording


def joined(
    settings: EngineSettings, types: TypeTable, opened: ExitStack, command: str | None = "{url}"
) -> tuple[EmbeddedTransport, str]:
    """Embed a server for a program, until ``opened`` closes; return a transport and its URL.

    If the program's command has a place for the URL, that has a token, which keeps out other users
    of this machine.
    """
    token = secrets.token_urlsafe() if "{url}" in (command or "") else None
    limits = Limits(service_s=2 * settings.patience.handshake)  # the engine reports first
    bridge = opened.enter_context(
        EmbeddedBridge(ServerSettings(token=token, types=types, limits=limits))
    )
    embedded = EmbeddedTransport(bridge)
    opened.callback(embedded.close)
    return embedded, bridge.url if token is None else f"{bridge.url}/?token={token}"


def at_server(url: str, settings: EngineSettings, opened: ExitStack) -> RosbridgeTransport:
    """Return a connection to a server that runs already, until ``opened`` closes."""
    server = RosbridgeTransport(url, settings.client, settings.ros)
    opened.callback(server.close)
    return server


class ExternalEngine(PlainEngine):
    """Flies missions with an external node or simulation, which may be started here.

    If a program that is started here fails twice under a specification, that is an
    ``EvaluationError`` of the specification. Every other problem is a ``TransportError``. Of
    ``repeats`` flights the median counts.
    """

    _lockstep: BusLockstep
    _opened: ExitStack

    def __init__(self, code: MissionCode, seed: int, settings: EngineSettings) -> None:
        super().__init__(code, seed)
        self.settings = settings
        self._world_process: KeptProcess | None = None

    def close(self) -> None:
        """End the programs and the connections."""
        self._opened.close()

    def started_world(self, opened: ExitStack) -> EmbeddedTransport:
        """Return the transport of a simulation, which the first flight starts."""
        command, types = self.settings.world_command or "", TypeTable(ros=self.settings.ros)
        transport, url = joined(self.settings, types, opened, command)
        self.keep_world(command, places_of(url), opened)
        return transport

    def keep_world(self, command: str, places: Places, opened: ExitStack) -> None:
        """Have the first flight start a simulation, if the settings have its command."""
        if self.settings.world_command is not None:
            restarts = self.settings.world_reset == RESTART
            self._world_process = KeptProcess(WORLD, command, places, restarts=restarts)
            opened.callback(self._world_process.close)

    def bundled(self, world: Transport) -> Transport:
        """Return the transport of a simulation, with bundles if the settings ask for them."""
        return BundlingTransport(world, is_ci=True) if self.settings.is_bundled else world

    def lock_step_with(self, transport: Transport, mind: Mind | None = None) -> None:
        """Prepare the lock-step with a simulation behind a transport."""
        code, settings = self.code, self.settings
        self._lockstep = BusLockstep(
            transport,
            code.mission,
            code.interface,
            code.truth,
            settings.patience,
            mind,
            self._world_process,
            settings.most_late(code.mission.duration),
        )
        self.interface = self._lockstep.interface

    def _culprit(self) -> KeptProcess | None:
        """Return the program that failed in the last flight, if it was started here."""
        return self._world_process if self._lockstep.is_to_blame else None

    def _evaluate(self, request: Request) -> Outcome:
        flights = [self._flown_well(request)]
        if not self.settings.is_foreign:
            return flights[0]
        n_late = self._lockstep.n_late
        while len(flights) < self.settings.repeats:
            flights.append(self._flown_well(request._replace(observer=None, tallies=[])))
            n_late += self._lockstep.n_late
        broken = [[t + m > 0 for t, m in zip(one.true, one.missed, strict=True)] for one in flights]
        flights.sort(key=lambda each: (sum(each.believed), sum(each.true), each.digest))
        repetition = Repetition(len(flights), n_late, tuple(map(sum, zip(*broken, strict=True))))
        return replace(flights[len(flights) // 2], repetition=repetition)

    def _flown_well(self, request: Request) -> Outcome:
        """Fly; if a program fails twice, that is an error of the specification."""
        for is_last in (request.observer is not None, True):
            try:
                return super()._evaluate(request)
            except TransportError as error:
                culprit = self._culprit()
                if culprit is None:
                    raise
                culprit.stop()
                if is_last:
                    raise EvaluationError(str(error)) from error
        raise AssertionError

    def _fly(self, flight: Flight, seed: int) -> None:
        self._lockstep.fly(flight, seed)


class InjectorEngine(ExternalEngine):
    """Flies missions with an external node as the collective intelligence.

    The node joins an embedded rosbridge server or an external one, or, on native ROS 2, a DDS
    domain. The built-in simulation runs in this process. An external one is at the same server or
    domain, or is started on an embedded server of its own.
    """

    def __init__(self, code: MissionCode, seed: int, settings: EngineSettings) -> None:
        super().__init__(code, seed, settings)
        patience = settings.patience
        self.patience = 4 * (patience.tick + patience.handshake)
        ros = 2 if settings.name == ROS2 else settings.ros
        speech = Speech.of(settings.node_mapping, code.mission, ros)
        with ExitStack() as opened:
            with errors_as_ours():
                transport, pace, places = self._join(speech, opened)
            self._process: KeptProcess | None = None
            if settings.node is not None:
                restarts = settings.node_reset == RESTART
                command = f"{self._variables}{settings.node}"
                self._process = KeptProcess(NODE, command, places, restarts=restarts)
                opened.callback(self._process.close)
            embedded = self._embedded
            self.node = Node(transport, speech, pace, patience, self._process)
            self.lock_step_with(self._world, self.node)
            transport.watch(self._lockstep.fail)
            if embedded is not None:
                embedded.on_refusal(
                    lambda topic, why: self.node.refuse(transport.unnamed(topic), why)
                )
            for each in speech.relayed:
                if settings.has_own_world:
                    raise UsageError(
                        f"[node] {each.topic.name}: is passed on to the simulation, but the "
                        f"built-in one has no {each.world.name}; expected --url, --world, or fields"
                    )
            self.node.pass_on(self._lockstep.advertise)
            self._opened = opened.pop_all()

    def _join(self, speech: Speech, opened: ExitStack) -> tuple[PrefixedTransport, Pace, Places]:
        """Create the transport of the simulation; return what reaches the node, and its pace."""
        settings, code = self.settings, self.code
        self._embedded: EmbeddedTransport | None = None
        self._variables = ""
        self._world: Transport = LocalBus()
        if settings.has_own_world:
            SimulationHost(self._world, code.simulation, code.mission, settings.patience)
        if settings.name == ROS2:
            return self._join_domain(speech, opened)
        if settings.url is not None:
            server = at_server(settings.url, settings, opened)
            if not settings.has_own_world:
                self._world = self.bundled(PrefixedTransport(server, settings.world_prefix))
            transport = PrefixedTransport(server, settings.node_prefix)
            return transport, Pace(settings.node_pace), places_of(settings.url)
        embedded, url = joined(settings, speech.types, opened, settings.node)
        self._embedded = embedded
        if not settings.has_own_world:
            self._world = self.bundled(self.started_world(opened))
        transport = PrefixedTransport(embedded, settings.node_prefix)
        return transport, Pace(settings.node_pace, embedded.barrier), places_of(url)

    def _join_domain(
        self, speech: Speech, opened: ExitStack
    ) -> tuple[PrefixedTransport, Pace, Places]:
        """Do so over DDS, with a participant each for the node and an external simulation."""
        from mrsfi_runtime.transport import ros2  # noqa: PLC0415 - an extra

        settings, prefix = self.settings, self.settings.node_prefix
        domain = ros2.domain_of(settings.domain, opened)
        self._variables = f"env {shlex.join(domain.variables)} "

        def participant(qos: Mapping[str, TopicQos]) -> ros2.Ros2Transport:
            joined = ros2.Ros2Transport(domain, speech.types, qos)
            opened.callback(joined.close)
            return joined

        places = {"{domain}": str(domain.number)}
        if not settings.has_own_world:
            self._world = PrefixedTransport(participant({}), settings.world_prefix)
            self.keep_world(f"{self._variables}{settings.world}", places, opened)
        node = participant(speech.qos(prefix))
        pace = Pace(settings.node_pace, node.barrier, node.settle, "calls of its parameter service")
        return PrefixedTransport(node, prefix), pace, places

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
        return super()._evaluate(request)

    def _record(self, specification: Specification, seed: int) -> "Recording":
        recording = super()._record(specification, seed)
        recording.received = self.node.speech.received
        return recording

    def _culprit(self) -> KeptProcess | None:
        return self._process if self.node.is_to_blame else super()._culprit()
