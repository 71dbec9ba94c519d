"""How a client receives a topic: how often, how many may wait, and in which encoding."""

from asyncio import AbstractEventLoop, TimerHandle
from collections import deque
from collections.abc import Callable, Collection
from typing import Any, NamedTuple

from mrsfi_bridge.encodings import COMPRESSIONS, PLAIN, Encoding, Outgoing
from mrsfi_bridge.errors import ProtocolError
from mrsfi_bridge.uses import Budget

_LONGEST_QUEUE = 10_000
_LONGEST_THROTTLE_MS = 1e9


class Wish(NamedTuple):
    """What one ``subscribe`` asks for.

    Parameters
    ----------
    throttle_s
        Least time between two messages.
    queue_length
        Messages that may wait for their time; beyond it the oldest are lost. With 0, what
        comes too early is lost.
    encoding
        How messages are sent.
    """

    throttle_s: float = 0.0
    queue_length: int = 0
    encoding: Encoding = PLAIN


def wish(operation: dict[str, Any]) -> Wish:
    """Return what a ``subscribe`` asks for.

    Raises
    ------
    ProtocolError
        If a value makes no sense.
    """
    throttle_ms = operation.get("throttle_rate", 0)
    queue_length = operation.get("queue_length", 0)
    if not 0 <= throttle_ms <= _LONGEST_THROTTLE_MS:
        raise ProtocolError(f"throttle_rate: expected 0 to {_LONGEST_THROTTLE_MS:g} ms")
    if queue_length < 0:
        raise ProtocolError("queue_length: expected 0 or more")
    return Wish(throttle_ms / 1000, min(queue_length, _LONGEST_QUEUE), wanted_encoding(operation))


def wanted_encoding(operation: dict[str, Any]) -> Encoding:
    """Return the encoding that an operation asks for.

    Raises
    ------
    ProtocolError
        If it is unknown.
    """
    compression = operation.get("compression", "none")
    size = operation.get("fragment_size")
    if compression not in COMPRESSIONS:
        known = ", ".join(COMPRESSIONS)
        raise ProtocolError(f"compression '{compression:.20}', expected one of {known}")
    if size is not None and size <= 0:
        raise ProtocolError("fragment_size: expected more than 0")
    return Encoding(compression, size)


def settled(wishes: Collection[Wish]) -> Wish:
    """Take wishes together: the most frequent, the shortest queue, the best compression."""
    compressions = {entry.encoding.compression for entry in wishes}
    sizes = [entry.encoding.fragment_size for entry in wishes]
    return Wish(
        min(entry.throttle_s for entry in wishes),
        min(entry.queue_length for entry in wishes),
        Encoding(
            max(compressions, key=COMPRESSIONS.index),
            min((size for size in sizes if size is not None), default=None),
        ),
    )


class Subscription:
    """One topic of one client, whatever number of times it subscribed.

    Parameters
    ----------
    scheduler
        Clock for throttling.
    budget
        What all clients' messages may take while they wait for their time.
    send
        Takes frames for the client.
    topic
        The topic as the client spells it.
    """

    __slots__ = ("_budget", "_last", "_queue", "_scheduler", "_send", "_timer", "_topic", "wish")

    def __init__(
        self,
        scheduler: AbstractEventLoop,
        budget: Budget,
        send: Callable[[bytes], None],
        topic: str,
    ) -> None:
        self._scheduler = scheduler
        self._budget = budget
        self._send = send
        self._topic = topic
        self.wish = Wish()
        self._queue: deque[bytes] = deque()
        self._last = float("-inf")
        self._timer: TimerHandle | None = None

    def receive(self, outgoing: Outgoing) -> None:
        """Send a message now, later or never, as the client asked."""
        wanted = self.wish
        if not wanted.throttle_s:
            while self._queue:
                self._send_next()
            self._send(outgoing.frames(self._topic, wanted.encoding))
        elif not self._queue and self._remaining() <= 0:
            self._last = self._scheduler.time()
            self._send(outgoing.frames(self._topic, wanted.encoding))
        elif wanted.queue_length:
            self._keep(outgoing.frames(self._topic, wanted.encoding))

    def close(self) -> None:
        """Forget what waits."""
        while self._queue:
            self._take()
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None

    def _keep(self, frames: bytes) -> None:
        """Have a message wait, and lose the oldest if there are too many."""
        while len(self._queue) >= self.wish.queue_length:
            self._take()
        while not self._budget.take(len(frames)):
            if not self._queue:
                return
            self._take()
        self._queue.append(frames)
        self._wait()

    def _take(self) -> bytes:
        frames = self._queue.popleft()
        self._budget.give_back(len(frames))
        return frames

    def _remaining(self) -> float:
        return self._last + self.wish.throttle_s - self._scheduler.time()

    def _send_next(self) -> None:
        self._last = self._scheduler.time()
        self._send(self._take())

    def _wait(self) -> None:
        if self._timer is None:
            self._timer = self._scheduler.call_later(max(self._remaining(), 0), self._wake)

    def _wake(self) -> None:
        self._timer = None
        if self._queue:
            self._send_next()
        if self._queue:
            self._wait()
