"""Topics and services below a prefix, so that two sides of a mission share a server."""

from collections.abc import Callable

from mrsfi_runtime.transport.topics import (
    NodeTransport,
    Payload,
    Provider,
    Publisher,
    Reply,
    Service,
    Topic,
)

_OF_SERVER = "/rosapi/"


class PrefixedTransport:
    """A transport whose topics and services begin with a prefix; those of the server do not."""

    def __init__(self, transport: NodeTransport, prefix: str) -> None:
        self._transport = transport
        self._prefix = prefix.rstrip("/")
        self.ros = transport.ros
        self.watch, self.close = transport.watch, transport.close
        self.call_later = transport.call_later

    def advertise(self, topic: Topic) -> Publisher:
        """Return the function that publishes on a topic."""
        return self._transport.advertise(topic._replace(name=self._named(topic.name)))

    def subscribe(self, topic: Topic, callback: Callable[[Payload], None]) -> None:
        """Have a callback receive every message of a topic."""
        self._transport.subscribe(topic._replace(name=self._named(topic.name)), callback)

    def provide(self, service: Service, provider: Provider) -> None:
        """Answer the calls of a service."""
        self._transport.provide(service._replace(name=self._named(service.name)), provider)

    def call(self, service: Service, request: Payload, on_reply: Callable[[Reply], None]) -> None:
        """Call a service; what the server says of topics is told without the prefix."""

        def reply(told: Reply) -> None:
            if "topics" in told.values:
                topics = told.values["topics"]
                names = [self.unnamed(name) for name in topics if name.startswith(self._prefix)]
                told = told._replace(values={**told.values, "topics": names})
            on_reply(told)

        if service.name.startswith(_OF_SERVER) and "topic" in request:
            request = {**request, "topic": self._named(request["topic"])}
        self._transport.call(service._replace(name=self._named(service.name)), request, reply)

    def unnamed(self, name: str) -> str:
        """Return what a topic of the server is called here."""
        return name.removeprefix(self._prefix)

    def _named(self, name: str) -> str:
        return name if name.startswith(_OF_SERVER) else f"{self._prefix}{name}"
