"""Topics: who publishes, who subscribes, and what is delivered. Knows no sockets."""

from collections.abc import Hashable
from dataclasses import dataclass, field
from typing import Any, Protocol

from mrsfi_bridge.errors import ProtocolError
from mrsfi_bridge.frames import PLAIN, Outgoing
from mrsfi_bridge.protocol import check_name
from mrsfi_bridge.settings import Limits, TypeTable
from mrsfi_bridge.structures import Structure


class Subscriber(Protocol):
    """Takes messages for a client."""

    def receive(self, outgoing: Outgoing) -> None:
        """Take one."""


@dataclass(slots=True)
class Publication:
    """What a client publishes on a topic: whether its last message is kept, and which it is."""

    is_latched: bool
    last: Outgoing | None = None
    n_bytes: int = 0


@dataclass(slots=True, eq=False)
class Topic:
    """A topic in use."""

    name: str
    structure: Structure
    n_numbered: int = 0
    publishers: dict[Hashable, Publication] = field(default_factory=dict)
    subscribers: dict[Hashable, Subscriber] = field(default_factory=dict)


class Broker:
    """Delivers messages from publishers to subscribers, in order, before it returns.

    Clients are told apart by any hashable object. A topic lives while somebody publishes or
    subscribes; ``topics`` has them by name, in the order in which they came.
    """

    def __init__(self, types: TypeTable, limits: Limits) -> None:
        self._types = types
        self._limits = limits
        self._n_latched_bytes = 0
        self.topics: dict[str, Topic] = {}

    def advertise(
        self, client: Hashable, name: str, type_name: str, *, is_latched: bool = False
    ) -> None:
        """Let a client publish on a topic.

        It is a ``ProtocolError`` if the type is unknown or conflicts, or there are too many topics.
        """
        topic = self._topic(name, type_name)
        publication = topic.publishers.setdefault(client, Publication(is_latched))
        publication.is_latched = is_latched

    def unadvertise(self, client: Hashable, name: str) -> None:
        """End the publications of a client on a topic, and forget what they latched."""
        topic = self.topics.get(name)
        if topic is not None and (publication := topic.publishers.pop(client, None)):
            self._n_latched_bytes -= publication.n_bytes
            self._release(topic)

    def publish(self, client: Hashable, name: str, message: Any) -> None:
        """Deliver a message to all subscribers of a topic.

        It is a ``ProtocolError`` if the client does not advertise the topic, the message does not
        fit its type, or latched messages take too much.
        """
        topic, publication = self._published(client, name)
        outgoing = Outgoing(topic.structure, topic.structure.convert(message))
        topic.n_numbered += 1
        outgoing.number(topic.n_numbered)
        if publication.is_latched:
            self._latch(topic, publication, outgoing)
        self._pass_on(topic, outgoing)

    def subscribe(
        self, client: Hashable, name: str, type_name: str | None, subscriber: Subscriber
    ) -> None:
        """Have a client receive what is published on a topic, and at once what is kept of before.

        A client that subscribes again gets what is kept only once. What ``advertise`` refuses
        is refused here, too.
        """
        topic = self._topic(name, type_name)
        is_known = client in topic.subscribers
        topic.subscribers[client] = subscriber
        for outgoing in () if is_known else self._kept(topic):
            subscriber.receive(outgoing)

    def unsubscribe(self, client: Hashable, name: str) -> None:
        """End the subscription of a client to a topic."""
        topic = self.topics.get(name)
        if topic is not None and topic.subscribers.pop(client, None) is not None:
            self._release(topic)

    def leave(self, client: Hashable) -> None:
        """End everything that a client does on topics."""
        for name in tuple(self.topics):
            self.unadvertise(client, name)
            self.unsubscribe(client, name)

    @property
    def is_idle(self) -> bool:
        """Whether all that was published was given to those who subscribe."""
        return True

    def _pass_on(self, topic: Topic, outgoing: Outgoing) -> None:
        """Give a message to all who subscribe now."""
        for subscriber in tuple(topic.subscribers.values()):
            subscriber.receive(outgoing)

    def _kept(self, topic: Topic) -> list[Outgoing]:
        """Return what those get who subscribe later: what is latched."""
        lasts = (publication.last for publication in topic.publishers.values())
        return [last for last in lasts if last is not None]

    def _published(self, client: Hashable, name: str) -> tuple[Topic, Publication]:
        """Return a topic that a client publishes on."""
        topic = self.topics.get(name)
        publication = None if topic is None else topic.publishers.get(client)
        if topic is None or publication is None:
            raise ProtocolError(
                f"topic '{name}' is not advertised; advertise it before you publish"
            )
        return topic, publication

    def _latch(self, topic: Topic, publication: Publication, outgoing: Outgoing) -> None:
        """Keep a message for those who subscribe later."""
        n_bytes = len(outgoing.frames(topic.name, PLAIN))
        n_all_bytes = self._n_latched_bytes + n_bytes - publication.n_bytes
        limit = self._limits.latched_bytes
        if n_all_bytes > limit:
            raise ProtocolError(f"topic '{topic.name}': latched messages take {limit} bytes")
        self._n_latched_bytes = n_all_bytes
        publication.last, publication.n_bytes = outgoing, n_bytes

    def _topic(self, name: str, type_name: str | None) -> Topic:
        """Return the topic of a name, made if it is new, after checks that its type agrees."""
        topic = self.topics.get(name)
        if topic is not None:
            wanted = topic.structure if type_name is None else self._types.message(type_name)
            if wanted is not topic.structure:
                found = topic.structure.name
                raise ProtocolError(f"topic '{name}' carries {found}, not {wanted.name}")
            return topic
        check_name(name, "topic")
        if type_name is None:
            raise ProtocolError(f"topic '{name}' has no type yet; name one")
        limit = self._limits.topics
        if len(self.topics) >= limit:
            raise ProtocolError(f"topic '{name}': there are {limit} topics, the limit")
        topic = self.topics[name] = Topic(name, self._types.message(type_name))
        return topic

    def _release(self, topic: Topic) -> None:
        """Forget a topic that nobody uses any more."""
        if not topic.publishers and not topic.subscribers:
            del self.topics[topic.name]
