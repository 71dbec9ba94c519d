"""In-process bus: a message reaches its subscribers before ``publish`` returns."""

from collections.abc import Callable

from mrsfi_runtime.errors import ProtocolError
from mrsfi_runtime.transport.topics import (
    FailureListener,
    Payload,
    Provider,
    Publisher,
    Reply,
    Service,
    Topic,
)


class LocalBus:
    """Delivers messages by plain calls, in the order in which subscribers came.

    A payload is handed on as it is: neither side may change it afterwards. An error in a
    callback stops the publisher, so nothing goes wrong unseen.
    """

    ros = 1

    def __init__(self) -> None:
        self._types: dict[str, str] = {}
        self._subscribers: dict[str, list[Callable[[Payload], None]]] = {}
        self._providers: dict[str, Provider] = {}

    def advertise(self, topic: Topic) -> Publisher:
        """Return the function that publishes on a topic.

        One that is in use with another type is a ``ProtocolError``, here and in ``subscribe``.
        """
        subscribers = self._join(topic)

        def publish(payload: Payload) -> None:
            for callback in subscribers:
                callback(payload)

        return publish

    def subscribe(self, topic: Topic, callback: Callable[[Payload], None]) -> None:
        """Have a callback receive every message of a topic."""
        self._join(topic).append(callback)

    def provide(self, service: Service, provider: Provider) -> None:
        """Answer the calls of a service; the newest provider answers."""
        self._providers[service.name] = provider

    def call(self, service: Service, request: Payload, on_reply: Callable[[Reply], None]) -> None:
        """Call a service; the reply comes before this returns."""
        provider = self._providers.get(service.name)
        if provider is None:
            on_reply(Reply({}, f"nobody provides service '{service.name}'"))
        else:
            on_reply(Reply(provider(request)))

    def watch(self, listener: FailureListener) -> None:
        """Do nothing: errors reach the publisher."""

    def close(self) -> None:
        """Forget all subscribers and providers."""
        self._providers.clear()
        for subscribers in self._subscribers.values():
            subscribers.clear()

    def _join(self, topic: Topic) -> list[Callable[[Payload], None]]:
        known = self._types.setdefault(topic.name, topic.type)
        if known != topic.type:
            raise ProtocolError(f"topic '{topic.name}' carries '{known}', not '{topic.type}'")
        return self._subscribers.setdefault(topic.name, [])
