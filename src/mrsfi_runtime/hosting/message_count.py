"""Counts the messages of every tick, so that none is lost, doubled or out of order unseen."""

from collections.abc import Callable

from mrsfi_runtime.errors import MrsfiError, ProtocolError, TransportError, TransportTimeout
from mrsfi_runtime.transport.topics import Payload, Publisher, PubSub, Topic

GRACE = 1.0
"""Seconds for which announced messages may be late: some servers keep order per topic only."""


class MessageCount:
    """What one side has received from the other in the current tick of a run.

    Each topic speaks at most once a tick. The last message of a tick announces how many there
    were.

    Attributes
    ----------
    tick
        The tick whose messages are expected.
    n_before
        Messages of the ticks of the run before this one.
    is_open
        Whether a run is on; otherwise nothing counts.

    Parameters
    ----------
    sender
        The other side, for messages.
    """

    def __init__(self, sender: str) -> None:
        self.tick = 0
        self.n_before = 0
        self.is_open = False
        self._sender = sender
        self._topics: set[str] = set()
        self._received: set[str] = set()
        self._announced: int | None = None

    def know(self, topic: str) -> None:
        """Add a topic to those that may speak."""
        self._topics.add(topic)

    def open(self) -> None:
        """Begin a run: expect tick 0."""
        self.tick = self.n_before = 0
        self._forget()
        self.is_open = True

    def close(self) -> None:
        """End the run."""
        self.is_open = False

    def count(self, topic: str) -> bool:
        """Count a message; return whether it completes its tick.

        Raises
        ------
        ProtocolError
            If the topic has spoken before in this tick, or more came than was announced.
        """
        if not self.is_open:
            return False
        if topic in self._received:
            raise ProtocolError(f"two messages on {topic}; expected one: a message came twice")
        self._received.add(topic)
        return self._is_complete()

    def announce(self, tick: int, n_messages: int) -> bool:
        """Take the number of messages of a tick; return whether all of them are there.

        Raises
        ------
        ProtocolError
            If it is not the tick expected, or more came than announced.
        """
        if tick != self.tick or self._announced is not None:
            raise ProtocolError(
                f"the {self._sender} announced tick {tick}; expected tick "
                f"{self.tick + (self._announced is not None)}: "
                "messages were lost, doubled or reordered"
            )
        self._announced = n_messages
        return self._is_complete()

    def turn(self) -> None:
        """Go on to the next tick."""
        self.tick += 1
        self.n_before += len(self._received)
        self._forget()

    def silent(self) -> list[str]:
        """Return the topics on which nothing came in this tick."""
        return sorted(self._topics - self._received)

    def overdue(self, silence: float, timeout: float) -> MrsfiError | None:
        """Return what is wrong after so many seconds without progress, if anything is."""
        if not self.is_open:
            return None
        if self._announced is not None and silence > GRACE:
            return TransportError(
                f"{len(self._received)} of {self._announced} messages of the {self._sender} "
                f"arrived; nothing on {', '.join(self.silent())}: a message was lost"
            )
        if silence > timeout:
            return TransportTimeout(
                f"the {self._sender} was silent for {timeout:g} s; look whether it still runs, "
                "or allow more with --timeout"
            )
        return None

    def _forget(self) -> None:
        self._received.clear()
        self._announced = None

    def _is_complete(self) -> bool:
        if self._announced is None or len(self._received) < self._announced:
            return False
        if len(self._received) > self._announced:
            raise ProtocolError(
                f"{len(self._received)} messages of the {self._sender} arrived; it announced "
                f"{self._announced}: a message came twice or out of order"
            )
        return True


class CountedTopics:
    """The topics of generated code, every message counted on its way in and out.

    Attributes
    ----------
    n_sent
        Messages published since the beginning of the run.
    is_muted
        Whether what is published is dropped, because no tick follows that it could act on.

    Parameters
    ----------
    transport
        Moves the messages.
    received
        Counts what comes in.
    proceed
        Called when a late message completes a tick that was announced before.
    """

    def __init__(
        self, transport: PubSub, received: MessageCount, proceed: Callable[[], None]
    ) -> None:
        self.n_sent = self._n_announced = 0
        self.is_muted = False
        self._transport = transport
        self._received = received
        self._proceed = proceed

    def begin(self) -> None:
        """Begin a run."""
        self.n_sent = self._n_announced = 0
        self.is_muted = False

    def announce(self) -> int:
        """Return how many messages were published since this was asked last."""
        n_before, self._n_announced = self._n_announced, self.n_sent
        return self.n_sent - n_before

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
        received, name = self._received, topic.name
        received.know(name)

        def receive(payload: Payload) -> None:
            is_complete = received.count(name)
            try:
                callback(payload)
            except (KeyError, TypeError, ValueError) as error:
                raise ProtocolError(f"{name} carried {payload!r}; expected {topic.type}") from error
            if is_complete:
                self._proceed()

        self._transport.subscribe(topic, receive)
