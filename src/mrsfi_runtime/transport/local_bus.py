"""In-process bus: a message reaches its subscribers before ``publish`` returns."""

from collections.abc import Callable

from mrsfi_runtime.errors import ProtocolError
from mrsfi_runtime.transport.topics import Payload, Publisher, Topic


class LocalBus:
    """Delivers messages by plain calls, in the order in which subscribers came.

    A payload is handed on as it is: neither side may change it afterwards. An error in a
    callback stops the publisher.
    """

    def __init__(self) -> None:
        self._types: dict[str, str] = {}
        self._subscribers: dict[str, list[Callable[[Payload], None]]] = {}

    def advertise(self, topic: Topic) -> Publisher:
        """Return the function that publishes on a topic.

        Raises
        ------
        ProtocolError
            If the topic is in use with another type.
        """
        subscribers = self._join(topic)

        def publish(payload: Payload) -> None:
            for callback in subscribers:
                callback(payload)

        return publish

    def subscribe(self, topic: Topic, callback: Callable[[Payload], None]) -> None:
        """Have a callback receive every message of a topic.

        Raises
        ------
        ProtocolError
            If the topic is in use with another type.
        """
        self._join(topic).append(callback)

    def close(self) -> None:
        """Forget all subscribers."""
        for subscribers in self._subscribers.values():
            subscribers.clear()

    def _join(self, topic: Topic) -> list[Callable[[Payload], None]]:
        known = self._types.setdefault(topic.name, topic.type)
        if known != topic.type:
            message = f"topic '{topic.name}' carries '{known}', not '{topic.type}'"
            raise ProtocolError(message)
        return self._subscribers.setdefault(topic.name, [])
