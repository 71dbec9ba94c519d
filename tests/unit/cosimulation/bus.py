"""A bus in memory: one queue, one thread, and messages that can be tampered with."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from queue import SimpleQueue
from threading import Thread

from mrsfi_runtime.cosimulation.bus_lockstep import BusLockstep, SimulationHost
from mrsfi_runtime.cosimulation.bus_topics import Patience
from mrsfi_runtime.cosimulation.lockstep import Mind
from mrsfi_runtime.errors import TransportClosed
from mrsfi_runtime.generated_code import MissionCode
from mrsfi_runtime.transport.topics import (
    FailureListener,
    LocalBus,
    Payload,
    Provider,
    Publisher,
    Reply,
    Service,
    Topic,
)

PATIENCE = Patience(tick=2.0, handshake=5.0)

Message = tuple[str, Payload]
Tamper = Callable[[Message], list[Message]]
"""What becomes of a message: nothing, itself, itself twice, others."""


class QueuedBus:
    """The server of the bus: a queue and a thread that empties it."""

    def __init__(self, tamper: Tamper | None = None) -> None:
        self._tamper = tamper or (lambda message: [message])
        self._queue: SimpleQueue[Callable[[], None] | None] = SimpleQueue()
        self.bus = LocalBus()
        self._publishers: dict[str, Publisher] = {}
        self._thread = Thread(target=self._empty)
        self._thread.start()

    def join(self) -> "QueuedTransport":
        """Return a transport of this bus."""
        return QueuedTransport(self)

    def advertise(self, topic: Topic) -> Publisher:
        """Return what puts a message into the queue."""
        self._publishers[topic.name] = self.bus.advertise(topic)

        def deliver(payload: Payload) -> None:
            for name, content in self._tamper((topic.name, payload)):
                self._publishers[name](content)

        return lambda payload: self._queue.put(lambda: deliver(payload))

    def put(self, work: Callable[[], None]) -> None:
        """Have the thread do something in turn."""
        self._queue.put(work)

    def close(self) -> None:
        """End the thread."""
        self._queue.put(None)
        self._thread.join()

    def _empty(self) -> None:
        while (work := self._queue.get()) is not None:
            work()


class QueuedTransport:
    """One side's connection to the bus; it can be cut."""

    ros = 1

    def __init__(self, bus: QueuedBus) -> None:
        self._bus = bus
        self._listener: FailureListener = _raise
        self._is_cut = False

    def advertise(self, topic: Topic) -> Publisher:
        publish = self._bus.advertise(topic)

        def publish_if_connected(payload: Payload) -> None:
            if self._is_cut:
                raise TransportClosed("cut")
            publish(payload)

        return publish_if_connected

    def subscribe(self, topic: Topic, callback: Callable[[Payload], None]) -> None:
        def receive(payload: Payload) -> None:
            try:
                callback(payload)
            except Exception as error:  # noqa: BLE001 - the listener decides
                self._listener(error)

        self._bus.bus.subscribe(topic, receive)

    def provide(self, service: Service, provider: Provider) -> None:
        self._bus.bus.provide(service, provider)

    def call(self, service: Service, request: Payload, on_reply: Callable[[Reply], None]) -> None:
        if self._is_cut:
            raise TransportClosed("cut")
        self._bus.put(lambda: self._bus.bus.call(service, request, on_reply))

    def watch(self, listener: FailureListener) -> None:
        self._listener = listener

    def close(self) -> None:
        """Do nothing: the bus is closed as a whole."""

    def cut(self) -> None:
        """Lose the connection."""
        self._is_cut = True
        self._listener(TransportClosed("cut"))


def _raise(error: Exception) -> None:
    raise error


@contextmanager
def sides(
    code: MissionCode,
    tamper: Tamper | None = None,
    patience: Patience = PATIENCE,
    patience_of_ci: Patience | None = None,
    mind: Mind | None = None,
) -> Iterator[tuple[SimulationHost, BusLockstep, QueuedTransport]]:
    """Yield the two sides of a mission on a bus, and the transport of the CI."""
    bus = QueuedBus(tamper)
    simulation = SimulationHost(bus.join(), code.simulation, code.mission, patience)
    transport = bus.join()
    try:
        yield (
            simulation,
            BusLockstep(
                transport,
                code.mission,
                code.interface,
                code.truth,
                patience_of_ci or patience,
                mind,
            ),
            transport,
        )
    finally:
        bus.close()
