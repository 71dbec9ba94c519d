"""Topics, services, what every transport offers, and the two transports that need no server.

A transport moves messages between the two sides of a mission. Generated code uses ``PubSub``;
``Transport`` adds services and errors, ``NodeTransport`` a clock. Messages of a
publisher arrive in order, and callbacks of one transport run one after the other. An error
in a callback reaches a listener or the publisher; no transport only logs it.

A ``LocalBus`` delivers by plain calls within one process. A ``PrefixedTransport`` adds a prefix
to the topics of another transport, so that several worlds share a server. ROS 1 and ROS 2 differ
in type names and times; ``type_name``, ``time_of`` and ``seconds_of`` handle both. Engines,
records and the command line import this module, so it imports no client of rosbridge.

Begin with ``Transport``; ``rosbridge`` has the transports over a server.

References
----------
Source paper, section III-F.
"""

from collections.abc import Callable
from typing import Any, Literal, NamedTuple, Protocol, TypeAlias

from mrsfi_runtime.errors import ProtocolError

Payload: TypeAlias = dict[str, Any]  # content of a message: field names of its ROS type to values
Publisher: TypeAlias = Callable[[Payload], None]  # publishes one message on one topic


class Topic(NamedTuple):
    """A topic and the ROS type of its messages, ``PACKAGE/TYPE`` whatever version of ROS."""

    name: str
    type: str


class Service(NamedTuple):
    """A service and its ROS type."""

    name: str
    type: str


SUBSCRIBERS = Service("/rosapi/subscribers", "rosapi/Subscribers")
PUBLISHERS = Service("/rosapi/publishers", "rosapi/Publishers")
TOPICS = Service("/rosapi/topics", "rosapi/Topics")
"""Services of a server, with the subscribers and publishers of a topic, and all topics."""

RELIABLE, BEST_EFFORT = "reliable", "best_effort"
TRANSIENT_LOCAL, VOLATILE = "transient_local", "volatile"
STRONG = {"reliability": RELIABLE, "durability": TRANSIENT_LOCAL}
"""What a subscriber may request in vain."""


class TopicQos(NamedTuple):
    """The quality of service of a topic of ROS 2; as by default in rclpy and rclcpp."""

    reliability: str = RELIABLE
    durability: str = VOLATILE
    depth: int = 10


class Reply(NamedTuple):
    """The answer of a service: its values, or the problem if it failed."""

    values: Payload
    problem: str = ""


Provider: TypeAlias = Callable[[Payload], Payload]
"""Answers the calls of a service: request to response."""

FailureListener: TypeAlias = Callable[[Exception], None]
"""Receives an error that would otherwise be lost."""


class PubSub(Protocol):
    """The part of a transport that generated code uses: to publish and to subscribe.

    Callbacks of one transport run one after the other, in one thread that may be another than
    the caller's; they must not block. The messages of a publisher arrive in their order.
    """

    def advertise(self, topic: Topic) -> Publisher:
        """Return the function that publishes on a topic."""

    def subscribe(self, topic: Topic, callback: Callable[[Payload], None]) -> None:
        """Have a callback receive every message of a topic, in order."""


class Transport(PubSub, Protocol):
    """Moves messages between the two sides of a mission, with the types of a version of ROS."""

    ros: int

    def provide(self, service: Service, provider: Provider) -> None:
        """Answer the calls of a service."""

    def call(self, service: Service, request: Payload, on_reply: Callable[[Reply], None]) -> None:
        """Call a service; ``on_reply`` gets the reply later, in the thread of the callbacks."""

    def watch(self, listener: FailureListener) -> None:
        """Report a lost connection and errors in callbacks to a function.

        There is one listener at a time. If the connection is already lost, it is called at once.
        """

    def close(self) -> None:
        """Give up all topics and services."""


SEE_LOG = "the server may have refused the type of a topic or service: see its log"
"""A genuine server reports that nowhere else; it appears as silence before the first tick."""


class NodeTransport(Transport, Protocol):
    """A transport with a clock; ``hint`` is what to look at if nothing arrives from a node."""

    hint: str

    def call_later(self, seconds: float, function: Callable[[], None]) -> None:
        """Call a function after a time, in the thread of the callbacks."""


ROS_VERSIONS = (1, 2)


def type_name(name: str, kind: str, ros: int) -> str:
    """Return the name of a type, ``PACKAGE/TYPE``, as a version of ROS spells it."""
    return name if ros == 1 else name.replace("/", f"/{kind}/")


def time_of(tick: int, ros: int, share: float = 0.0) -> Payload:
    """Return the time of a tick, or of a share of the next: one tick is one second."""
    rest = round(share * 1e9)
    return {"secs": tick, "nsecs": rest} if ros == 1 else {"sec": tick, "nanosec": rest}


def seconds_of(time: Payload) -> int:
    """Return the seconds of a time, of either version."""
    seconds: int = time["sec"] if "sec" in time else time["secs"]
    return seconds


Client: TypeAlias = Literal["wire", "asyncio", "twisted"]
"""Kind of connection: mrsfi's or one of roslibpy's; a process with ``twisted`` can use no other."""

CLIENTS: tuple[Client, ...] = ("wire", "asyncio", "twisted")


def without_token(url: str) -> str:
    """Return a URL as it may be shown: a query may hold a token."""
    return url.partition("?")[0]


class LocalBus:
    """Delivers messages by plain calls, in the order in which subscribers came.

    A payload is not copied: neither side may change it afterwards. An error in a
    callback is raised in the publisher.
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


_OF_SERVER = "/rosapi/"


class PrefixedTransport:
    """A transport with a prefix on all topics and services except those of the server."""

    def __init__(self, transport: NodeTransport, prefix: str) -> None:
        self._transport = transport
        self._prefix = prefix.rstrip("/")
        self.ros, self.hint = transport.ros, transport.hint
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
        """Call a service; topic names in a server's answer lose the prefix."""

        def reply(answer: Reply) -> None:
            if "topics" in answer.values:
                topics = answer.values["topics"]
                names = [self.unnamed(name) for name in topics if name.startswith(self._prefix)]
                answer = answer._replace(values={**answer.values, "topics": names})
            on_reply(answer)

        if service.name.startswith(_OF_SERVER) and "topic" in request:
            request = {**request, "topic": self._named(request["topic"])}
        self._transport.call(service._replace(name=self._named(service.name)), request, reply)

    def unnamed(self, name: str) -> str:
        """Return the name of a topic without the prefix."""
        return name.removeprefix(self._prefix)

    def _named(self, name: str) -> str:
        return name if name.startswith(_OF_SERVER) else f"{self._prefix}{name}"
