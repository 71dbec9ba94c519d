"""Counts the messages of every tick, so that none is lost, doubled or out of order unseen."""

import sys
from collections.abc import Callable, Mapping
from typing import Any, Final

from mrsfi_runtime.errors import MrsfiError, ProtocolError, TransportError, TransportTimeout
from mrsfi_runtime.transport.topics import Payload, Publisher, PubSub, Topic, seconds_of

GRACE = 1.0
"""Seconds for which announced messages may be late: some servers keep order per topic only."""


def _is_number(value: Any) -> bool:
    return type(value) in (int, float) and abs(value) <= sys.float_info.max  # no NaN either


def _is_integer(value: Any) -> bool:
    return type(value) is int and abs(value) < 2**63


def _is_place(payload: Payload) -> bool:
    return all(_is_number(payload[axis]) for axis in "xyz")


_FORMS: Final[Mapping[str, Callable[[Payload], bool]]] = {
    "geometry_msgs/Point": _is_place,
    "geometry_msgs/Vector3": _is_place,
    "rosgraph_msgs/Clock": lambda payload: _is_integer(seconds_of(payload["clock"])),
    "std_msgs/Bool": lambda payload: type(payload["data"]) is bool,
    "std_msgs/Float64": lambda payload: _is_number(payload["data"]),
    "std_msgs/Float64MultiArray": lambda payload: all(map(_is_number, payload["data"])),
    "std_msgs/Int64": lambda payload: _is_integer(payload["data"]),
}
"""Whether a message is of its type, and all its numbers are finite: not every server looks."""


class CountedTopics:
    """The topics of generated code on one side of a run, every message counted in and out.

    Each topic speaks at most once a tick. The last message of a tick announces how many there were;
    ``proceed`` is called when a late one completes a tick that was announced before. ``tick`` is
    that whose messages are expected, ``n_before`` counts those that came before it, ``n_sent`` what
    was published in the run. Unless a run ``is_open``, nothing that comes in counts; while it
    ``is_muted``, what is published is dropped, because no tick follows that it could act on.
    """

    def __init__(self, transport: PubSub, sender: str, proceed: Callable[[], None]) -> None:
        self._transport = transport
        self._sender = sender
        self._proceed = proceed
        self._topics: set[str] = set()
        self._received: set[str] = set()
        self._n_expected: int | None = None
        self.open()
        self.is_open = False

    def open(self) -> None:
        """Begin a run: expect tick 0."""
        self.tick = self.n_before = self.n_sent = self._n_told = 0
        self.is_open, self.is_muted = True, False
        self._forget()

    def close(self) -> None:
        """End the run."""
        self.is_open = False

    def advertise(self, topic: Topic) -> Publisher:
        """Return the function that publishes on a topic and counts."""
        publish = self._transport.advertise(topic)

        def publish_counted(payload: Payload) -> None:
            if not self.is_muted:
                self.n_sent += 1
                publish(payload)

        return publish_counted

    def subscribe(self, topic: Topic, callback: Callable[[Payload], None]) -> None:
        """Have a callback receive every message of a topic, after it was counted."""
        name = topic.name
        self._topics.add(name)
        is_of_form = _FORMS[topic.type]

        def receive(payload: Payload) -> None:
            is_complete = self.count(name)
            try:
                is_sound = is_of_form(payload)
            except (KeyError, TypeError):
                is_sound = False
            if not is_sound:
                raise ProtocolError(
                    f"{name} carried {payload!r}; expected {topic.type} of finite numbers"
                )
            callback(payload)
            if is_complete:
                self._proceed()

        self._transport.subscribe(topic, receive)

    def count(self, topic: str) -> bool:
        """Count a message that came in; return whether it completes its tick."""
        if not self.is_open:
            return False
        if topic in self._received:
            raise ProtocolError(f"two messages on {topic}; expected one: a message came twice")
        self._received.add(topic)
        return self._is_complete()

    def announced(self, tick: int, n_messages: int) -> bool:
        """Take the number of messages of a tick; return whether all of them are there."""
        if tick != self.tick or self._n_expected is not None:
            raise ProtocolError(
                f"the {self._sender} announced tick {tick}; expected tick "
                f"{self.tick + (self._n_expected is not None)}: "
                "messages were lost, doubled or reordered"
            )
        self._n_expected = n_messages
        return self._is_complete()

    def turn(self) -> None:
        """Go on to the next tick."""
        self.tick += 1
        self.n_before += len(self._received)
        self._forget()

    def announce(self) -> int:
        """Return how many messages were published since this was asked last."""
        n_before, self._n_told = self._n_told, self.n_sent
        return self.n_sent - n_before

    def overdue(self, silence: float, timeout: float) -> MrsfiError | None:
        """Return what is wrong after so many seconds without progress, if anything is."""
        if not self.is_open:
            return None
        if self._n_expected is not None and silence > GRACE:
            silent = ", ".join(sorted(self._topics - self._received))
            return TransportError(
                f"{len(self._received)} of {self._n_expected} messages of the {self._sender} "
                f"arrived; nothing on {silent}: a message was lost"
            )
        if silence > timeout:
            return TransportTimeout(
                f"the {self._sender} was silent for {timeout:g} s; look whether it still runs, "
                "or allow more with --timeout"
            )
        return None

    def _forget(self) -> None:
        self._received.clear()
        self._n_expected = None

    def _is_complete(self) -> bool:
        if self._n_expected is None or len(self._received) < self._n_expected:
            return False
        if len(self._received) > self._n_expected:
            raise ProtocolError(
                f"{len(self._received)} messages of the {self._sender} arrived; it announced "
                f"{self._n_expected}: a message came twice or out of order"
            )
        return True
