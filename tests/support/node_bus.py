"""Flights with a node in this process: a bus with the clock and the services of a server."""

from contextlib import contextmanager
from queue import SimpleQueue
from threading import Thread
from unittest.mock import patch

from mrsfi_bridge.settings import TypeTable
from mrsfi_runtime.cosimulation import node as node_of
from mrsfi_runtime.cosimulation.bus_lockstep import BusLockstep, SimulationHost
from mrsfi_runtime.cosimulation.bus_topics import BARRIER, Pace, Patience
from mrsfi_runtime.cosimulation.node import Node
from mrsfi_runtime.cosimulation.node_speech import Speech
from mrsfi_runtime.transport.rosbridge import ListenedTransport
from mrsfi_runtime.transport.topics import LocalBus, Reply, Service, Topic
from tests.support.two_sides import BusEngine

PATIENCE = Patience(tick=1.0, handshake=2.0)


class NodeBus(ListenedTransport):
    """Delivers at once, in a thread of its own; ``said`` is what was published on it."""

    ros = 1

    def __init__(self):
        super().__init__()
        self.bus, self.said, self.heard = LocalBus(), [], set()
        self._queue = SimpleQueue()
        Thread(target=self._work, daemon=True).start()

    def advertise(self, topic):
        publish = self.bus.advertise(topic)

        def tell(payload):
            self.said.append((topic.name, payload))
            publish(payload)

        return tell

    def subscribe(self, topic, callback):
        self.heard.add(topic.name)
        self.bus.subscribe(topic, self.told(callback))

    def provide(self, service, provider):
        self.bus.provide(service, provider)

    def call(self, service, request, on_reply):
        if service.name == "/rosapi/topics":
            on_reply(Reply({"topics": [*self.bus._types]}))
        elif service.name == "/rosapi/subscribers":
            on_reply(Reply({"subscribers": ["n"] * (request["topic"] in self.heard)}))
        else:
            self.bus.call(service, request, on_reply)

    def call_later(self, _seconds, function):
        self._queue.put(self.told(function))

    def close(self):
        self._queue.put(None)

    def _work(self):
        while (function := self._queue.get()) is not None:
            try:
                function()
            except Exception:  # noqa: BLE001 - the listener was told
                continue


@contextmanager
def engine_with(code, mapping, node, pace=BARRIER):
    """Yield an engine that flies with a node, and its bus.

    ``node`` gets a function that subscribes and one that advertises, and is reset by a service.
    """
    bus, world = NodeBus(), LocalBus()
    bus.provide(Service("/mission/reset", "std_srvs/Trigger"), lambda _: {"success": True})
    speech = Speech(mapping, code.mission, TypeTable())
    between = Node(bus, speech, Pace(pace, lambda then: bus.call_later(0.0, then)), PATIENCE)
    SimulationHost(world, code.simulation, code.mission, PATIENCE)
    lockstep = BusLockstep(world, code.mission, code.interface, code.truth, PATIENCE, between)
    between.pass_on(lockstep.advertise)
    bus.watch(lockstep.fail)
    node(
        lambda *topic, then: bus.subscribe(Topic(*topic), then), lambda *t: bus.advertise(Topic(*t))
    )
    try:
        with patch.object(node_of, "_STEADY", 0.0):  # it subscribed before
            yield BusEngine(code, 1, lockstep), bus, between
    finally:
        bus.close()
