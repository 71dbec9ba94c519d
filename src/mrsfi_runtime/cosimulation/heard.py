"""What a topic says in a tick: nothing of an earlier one can stand for what is missing."""

from mrsfi_runtime.errors import ProtocolError
from mrsfi_runtime.transport.topics import Payload, PubSub, Topic


class Heard:
    """The message of a topic that came in this tick, if one did."""

    def __init__(self, transport: PubSub, topic: Topic) -> None:
        self.name = topic.name
        self._payload: Payload | None = None
        transport.subscribe(topic, self._receive)

    @property
    def is_new(self) -> bool:
        """Return whether a message came that nobody took."""
        return self._payload is not None

    def forget(self) -> None:
        """Be as before the first message."""
        self._payload = None

    def take(self) -> Payload:
        """Return the message of this tick, once; raise ``ProtocolError`` if none came."""
        payload, self._payload = self._payload, None
        if payload is None:
            raise self.missing()
        return payload

    def missing(self) -> ProtocolError:
        """Return what to raise where a tick had to bring a message."""
        return ProtocolError(
            f"nothing on {self.name}; the simulation has to publish it in this tick (docs/bus.md)"
        )

    def _receive(self, payload: Payload) -> None:
        self._payload = payload
