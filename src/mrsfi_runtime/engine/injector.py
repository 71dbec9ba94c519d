"""Evaluates fault specifications with a team's own node as the collective intelligence.

The node is told on topics of its own what would be believed, and its commands are flown. The world
is ours, in this process, and the node joins a server that is embedded here; or the world is the
team's, and world, injector and node are on one server.
"""

import secrets
from contextlib import ExitStack
from typing import TYPE_CHECKING

from mrsfi_bridge.embedded import EmbeddedBridge
from mrsfi_bridge.errors import BridgeError
from mrsfi_bridge.settings import Limits, ServerSettings, TypeTable
from mrsfi_runtime.cosimulation.bus_lockstep import BusLockstep, SimulationHost
from mrsfi_runtime.cosimulation.bus_topics import BundlingTransport
from mrsfi_runtime.cosimulation.lockstep import Flight, Observer
from mrsfi_runtime.cosimulation.node import Node
from mrsfi_runtime.cosimulation.node_mapping import Pace
from mrsfi_runtime.cosimulation.node_speech import Speech, held_commands, out_of_reach
from mrsfi_runtime.engine.flights import PlainEngine
from mrsfi_runtime.engine.node_process import NodeProcess
from mrsfi_runtime.errors import EvaluationError, SpecificationError, TransportError, UsageError
from mrsfi_runtime.generated_code import MissionCode
from mrsfi_runtime.kernel.injections import FaultTally
from mrsfi_runtime.model.faults import FaultPool, Specification
from mrsfi_runtime.model.mission import Outcome
from mrsfi_runtime.record.engine_settings import RESTART, EngineSettings
from mrsfi_runtime.transport.rosbridge import EmbeddedTransport, RosbridgeTransport, as_ours
from mrsfi_runtime.transport.topics import LocalBus, PrefixedTransport

if TYPE_CHECKING:
    from mrsfi_runtime.transport.topics import Transport


class InjectorEngine(PlainEngine):
    """Flies missions with a node between what is heard and what is commanded.

    What a node does wrong that is started here is an ``EvaluationError`` if it does so twice: it
    belongs to the specification. All else that goes wrong on the way is a ``TransportError``.
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
            self.node = Node(
                transport,
                speech,
                Pace(
                    settings.node_pace,
                    self._embedded.barrier if self._embedded is not None else None,
                ),
                patience,
                self._process,
                restarts=settings.node_reset == RESTART,
            )
            self._lockstep = BusLockstep(
                self._world, code.mission, code.interface, code.truth, patience, self.node
            )
            transport.watch(self._lockstep.fail)
            if self._embedded is not None:
                self._embedded.on_refusal(
                    lambda topic, why: self.node.refuse(transport.unnamed(topic), why)
                )
            self._pass_on()
            self._opened = opened.pop_all()
        self.interface = self._lockstep.interface

    def close(self) -> None:
        """End the node and the connection."""
        self._opened.close()

    def _pass_on(self) -> None:
        """Have what our world does not understand passed on to somebody else's."""
        for each in self.node.speech.relayed:
            if self._settings.url is None:
                raise UsageError(
                    f"[node] {each.topic.name}: is passed on to the world, and ours knows no "
                    f"{each.world.name}; expected --url, or fields"
                )
        self.node.pass_on(self._lockstep.advertise)

    def _join(self, types: TypeTable, opened: ExitStack) -> PrefixedTransport:
        """Return the transport of the node, after that of the world was made."""
        settings, code = self._settings, self.code
        self._embedded: EmbeddedTransport | None = None
        if settings.url is not None:
            joined = RosbridgeTransport(settings.url, settings.client, settings.ros)
            opened.callback(joined.close)
            self._url = settings.url
            world = PrefixedTransport(joined, settings.world_prefix)
            self._world: Transport = (
                BundlingTransport.of_ci(world) if settings.is_bundled else world
            )
            return PrefixedTransport(joined, settings.node_prefix)
        # other users of this machine are no part of the mission
        token = secrets.token_urlsafe() if "{url}" in (settings.node or "") else None
        limits = Limits(service_s=2 * settings.patience.handshake)  # who waits is the first to tell
        server = ServerSettings(token=token, types=types, limits=limits)
        bridge = opened.enter_context(EmbeddedBridge(server))
        self._url = bridge.url if token is None else f"{bridge.url}/?token={token}"
        embedded = self._embedded = EmbeddedTransport(bridge)
        opened.callback(embedded.close)
        self._world = LocalBus()
        self._host = SimulationHost(self._world, code.simulation, code.mission, settings.patience)
        return PrefixedTransport(embedded, settings.node_prefix)

    def _evaluate(
        self,
        specification: Specification,
        seed: int,
        pool: FaultPool,
        observer: Observer | None,
        tallies: list[FaultTally],
    ) -> Outcome:
        beyond = out_of_reach(self.code.mission, pool, self.node.speech)
        for timed in specification:
            if timed.fault in beyond:
                raise SpecificationError(
                    f"fault '{timed.fault}' cannot be injected: it touches {beyond[timed.fault]}, "
                    "of which no topic tells the node; map one in [node] of mrsfi.toml, or leave "
                    "the fault out (docs/node.md)",
                    (timed.fault,),
                )
        self.node.held = [*held_commands(self.code.mission, pool, specification)]
        flights = [self._flown_well(specification, seed, pool, observer, tallies)]
        while len(flights) < self._settings.node_repeats:
            flights.append(self._flown_well(specification, seed, pool, None, []))
        flights.sort(key=lambda each: (sum(each.believed), sum(each.true), each.digest))
        return flights[len(flights) // 2]

    def _flown_well(
        self,
        specification: Specification,
        seed: int,
        pool: FaultPool,
        observer: Observer | None,
        tallies: list[FaultTally],
    ) -> Outcome:
        """Fly; what the node does wrong twice belongs to the specification."""
        for is_last in (observer is not None, True):
            try:
                return super()._evaluate(specification, seed, pool, observer, tallies)
            except TransportError as error:
                if self._process is None or not self.node.is_to_blame:
                    raise
                self._process.stop()
                if is_last:
                    raise EvaluationError(str(error)) from error
        raise AssertionError

    def _fly(self, flight: Flight, seed: int) -> None:
        self._lockstep.fly(flight, seed)
