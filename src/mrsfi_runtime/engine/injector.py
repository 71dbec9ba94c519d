"""The engine for an external node as the collective intelligence, with faults in its messages.

The node receives the faulty reports on topics of its own, and the engine flies its commands. It
joins an embedded rosbridge server or an external one, or, on native ROS 2, a DDS domain. The
built-in simulation runs in this process. An external one is at the same server or domain, or is
started on an embedded server of its own.
"""

import shlex
from contextlib import ExitStack
from typing import TYPE_CHECKING

from mrsfi_bridge.errors import BridgeError
from mrsfi_runtime.cosimulation.bus_lockstep import SimulationHost
from mrsfi_runtime.cosimulation.bus_topics import Pace
from mrsfi_runtime.cosimulation.node import Node
from mrsfi_runtime.cosimulation.node_speech import Speech, held_commands, out_of_reach
from mrsfi_runtime.engine.external import NODE, ExternalEngine, KeptProcess, joined, places_of
from mrsfi_runtime.engine.flights import Request
from mrsfi_runtime.errors import SpecificationError, UsageError
from mrsfi_runtime.generated_code import MissionCode
from mrsfi_runtime.model.mission import Outcome
from mrsfi_runtime.record.engine_settings import RESTART, ROS2, EngineSettings
from mrsfi_runtime.transport.rosbridge import EmbeddedTransport, RosbridgeTransport, as_ours
from mrsfi_runtime.transport.topics import LocalBus, PrefixedTransport

if TYPE_CHECKING:
    from collections.abc import Mapping

    from mrsfi_runtime.engine.external import Places
    from mrsfi_runtime.transport.topics import TopicQos, Transport


class InjectorEngine(ExternalEngine):
    """Flies missions with an external node as the collective intelligence."""

    def __init__(self, code: MissionCode, seed: int, settings: EngineSettings) -> None:
        super().__init__(code, seed, settings)
        patience = settings.patience
        self.patience = 4 * (patience.tick + patience.handshake)
        speech = Speech.of(settings.node_mapping, code.mission, settings.version_of_ros)
        with ExitStack() as opened:
            try:
                transport, pace, places = self._join(speech, opened)
            except BridgeError as error:
                raise as_ours(error) from error
            self._process: KeptProcess | None = None
            if settings.node is not None:
                restarts = settings.node_reset == RESTART
                command = f"{self._variables}{settings.node}"
                self._process = KeptProcess(NODE, command, places, restarts=restarts)
                opened.callback(self._process.close)
            embedded = self._embedded
            self.node = Node(transport, speech, pace, patience, self._process)
            self._lockstep = self.lockstep(self._world, self.node)
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
        self.interface = self._lockstep.interface

    def close(self) -> None:
        """End the node and the connection."""
        self._opened.close()

    def _join(self, speech: Speech, opened: ExitStack) -> "tuple[PrefixedTransport, Pace, Places]":
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
            server = RosbridgeTransport(settings.url, settings.client, settings.ros)
            opened.callback(server.close)
            if not settings.has_own_world:
                self._world = self.bundled(PrefixedTransport(server, settings.world_prefix))
            transport = PrefixedTransport(server, settings.node_prefix)
            return transport, Pace(settings.node_pace), places_of(settings.url)
        embedded, url = joined(settings.node, settings, speech.types, opened)
        self._embedded = embedded
        if not settings.has_own_world:
            self._world = self.bundled(self.started_world(opened))
        transport = PrefixedTransport(embedded, settings.node_prefix)
        return transport, Pace(settings.node_pace, embedded.barrier), places_of(url)

    def _join_domain(
        self, speech: Speech, opened: ExitStack
    ) -> "tuple[PrefixedTransport, Pace, Places]":
        """Do so over DDS, with a participant each for the node and an external simulation."""
        from mrsfi_runtime.transport import ros2  # noqa: PLC0415 - an extra

        settings, prefix = self.settings, self.settings.node_prefix
        domain = ros2.domain_of(settings.domain, opened)
        self._variables = f"env {shlex.join(domain.variables)} "

        def participant(qos: "Mapping[str, TopicQos]") -> ros2.Ros2Transport:
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

    def _culprit(self) -> KeptProcess | None:
        return self._process if self.node.is_to_blame else super()._culprit()
