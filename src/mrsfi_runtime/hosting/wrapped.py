"""A transport around another one."""

from collections.abc import Callable

from mrsfi_runtime.transport.topics import (
    FailureListener,
    Payload,
    Provider,
    Publisher,
    Reply,
    Service,
    Topic,
    Transport,
)


class WrappedTransport:
    """Passes everything on; who inherits it does something to the messages.

    Parameters
    ----------
    transport
        Moves the messages.
    """

    def __init__(self, transport: Transport) -> None:
        self._transport = transport

    def advertise(self, topic: Topic) -> Publisher:
        """Return the function that publishes on a topic."""
        return self._transport.advertise(topic)

    def subscribe(self, topic: Topic, callback: Callable[[Payload], None]) -> None:
        """Have a callback receive every message of a topic."""
        self._transport.subscribe(topic, callback)

    def provide(self, service: Service, provider: Provider) -> None:
        """Answer the calls of a service."""
        self._transport.provide(service, provider)

    def call(self, service: Service, request: Payload, on_reply: Callable[[Reply], None]) -> None:
        """Call a service."""
        self._transport.call(service, request, on_reply)

    def watch(self, listener: FailureListener) -> None:
        """Have a function told of a lost connection, and of errors in callbacks."""
        self._transport.watch(listener)

    def close(self) -> None:
        """Give up all topics and services."""
        self._transport.close()
