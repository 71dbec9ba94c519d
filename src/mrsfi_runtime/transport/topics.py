"""Topics and the interface that every transport offers.

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
    """A topic and the ROS type of its messages."""

    name: str
    type: str


class Transport(Protocol):
    """Moves messages between the two sides of a mission."""

    def advertise(self, topic: Topic) -> Publisher:
        """Return the function that publishes on a topic."""

    def subscribe(self, topic: Topic, callback: Callable[[Payload], None]) -> None:
        """Have a callback receive every message of a topic, in order."""

    def close(self) -> None:
        """Give up all topics."""
