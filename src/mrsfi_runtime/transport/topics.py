"""Topics, services and the interface that every transport offers.

References
----------
Source paper, section III-F.
"""

from collections.abc import Callable
from typing import Any, NamedTuple, Protocol, TypeAlias

Payload: TypeAlias = dict[str, Any]
"""Content of a message: field names of its ROS type to values."""

Publisher: TypeAlias = Callable[[Payload], None]
"""Publishes one message on one topic."""


class Topic(NamedTuple):
    """A topic and the ROS type of its messages, ``PACKAGE/TYPE`` whatever version of ROS."""

    name: str
    type: str


class Service(NamedTuple):
    """A service and its ROS type."""

    name: str
    type: str


class Reply(NamedTuple):
    """What came back from a service: its values, or the problem if it failed."""

    values: Payload
    problem: str = ""


Provider: TypeAlias = Callable[[Payload], Payload]
"""Answers the calls of a service: request to response."""

FailureListener: TypeAlias = Callable[[Exception], None]
"""Told of an error that nobody else would see."""


class PubSub(Protocol):
    """What generated code needs of a transport: topics to publish on, and to subscribe to.

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
        """Have a function told of a lost connection, and of errors in callbacks.

        One listener at a time; one that comes after the connection was lost is told at once.
        """

    def close(self) -> None:
        """Give up all topics and services."""


class NodeTransport(Transport, Protocol):
    """A transport with a clock."""

    def call_later(self, seconds: float, function: Callable[[], None]) -> None:
        """Call a function after a time, in the thread of the callbacks."""
