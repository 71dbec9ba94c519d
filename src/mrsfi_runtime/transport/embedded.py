"""Transport of the side that carries the rosbridge server in its own process.

It joins the server's own thread without a socket: what it publishes within one callback
leaves in one write.
"""

from collections.abc import Callable
from concurrent.futures import Future
from threading import get_ident
from typing import Any, TypeVar

from mrsfi_bridge.embedded import EmbeddedBridge
from mrsfi_bridge.errors import BridgeError
from mrsfi_runtime.errors import TransportClosed
from mrsfi_runtime.transport.bridge_errors import as_ours
from mrsfi_runtime.transport.listened import ListenedTransport
from mrsfi_runtime.transport.topics import (
    Payload,
    Provider,
    Publisher,
    Reply,
    Service,
    Topic,
)

T = TypeVar("T")


class EmbeddedTransport(ListenedTransport):
    """A client of an embedded bridge that has started; its callbacks run in the bridge's thread.

    Closing the transport leaves the bridge open for others.
    """

    def __init__(self, bridge: EmbeddedBridge) -> None:
        super().__init__()
        self._bridge = bridge
        self.ros = bridge.ros
        self._thread = 0
        self._thread = self._run(get_ident)
        self._client = self._run(bridge.local_client)

    def advertise(self, topic: Topic) -> Publisher:
        """Return the function that publishes on a topic."""
        name, client = topic.name, self._client
        self._run(lambda: client.advertise(name, topic.type))

        def publish(payload: Payload) -> None:
            self._run(lambda: client.publish(name, payload))

        return publish

    def subscribe(self, topic: Topic, callback: Callable[[Payload], None]) -> None:
        """Have a callback receive every message of a topic."""
        receive = self.told(callback)
        self._run(lambda: self._client.subscribe(topic.name, topic.type, receive))

    def provide(self, service: Service, provider: Provider) -> None:
        """Answer the calls of a service."""
        answer = self.told(provider)
        self._run(lambda: self._client.advertise_service(service.name, service.type, answer))

    def call(self, service: Service, request: Payload, on_reply: Callable[[Reply], None]) -> None:
        """Call a service."""

        def reply(is_answer: bool, values: Any) -> None:
            on_reply(Reply(values) if is_answer else Reply({}, str(values)))

        self._run(lambda: self._client.call(service.name, request, self.told(reply)))

    def call_later(self, seconds: float, function: Callable[[], None]) -> None:
        """Call a function after a time, as callbacks are."""
        self._run(lambda: self._bridge.call_later(seconds, self.told(function)))

    def barrier(self, then: Callable[[], None]) -> None:
        """Call a function when all clients of the server have answered what they were told."""
        self._run(lambda: self._bridge.barrier(self.told(then)))

    def on_refusal(self, listener: Callable[[str, str], None]) -> None:
        """Have a function told the topic and the reason of what clients say and nobody hears."""
        self._run(lambda: self._bridge.on_refusal(self.told(listener)))

    def close(self) -> None:
        """Give up all topics and services."""
        if self.lost is None:
            self._run(self._client.close)
            self.lost = TransportClosed("the embedded transport was closed")

    def _run(self, function: Callable[[], T]) -> T:
        """Run a function in the bridge's thread and return what it returns."""
        self.require_open()
        try:
            return function() if get_ident() == self._thread else self._run_there(function)
        except BridgeError as error:
            raise as_ours(error) from error

    def _run_there(self, function: Callable[[], T]) -> T:
        done: Future[T] = Future()

        def run() -> None:
            try:
                done.set_result(function())
            except Exception as error:  # noqa: BLE001 - raised where it was asked for
                done.set_exception(error)

        self._bridge.call_soon(run)
        return done.result()
