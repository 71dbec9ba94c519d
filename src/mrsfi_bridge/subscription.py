"""What a client uses, how many times; and how it receives a topic: how often, in which encoding."""

from asyncio import AbstractEventLoop, TimerHandle
from collections import deque
from collections.abc import Callable, Collection
from typing import Any, NamedTuple, TypeAlias, TypeVar

from mrsfi_bridge.errors import ProtocolError
from mrsfi_bridge.frames import COMPRESSIONS, PLAIN, Encoding, Outgoing

V = TypeVar("V")

UseId: TypeAlias = str | int | None
"""What tells the uses of one topic by one client apart."""

_LONGEST_QUEUE = 10_000
_LONGEST_THROTTLE_MS = 1e9


class Uses(dict[str, dict[UseId, V]]):
    """Topics that a client uses, each under the identifiers that it gave, ``limit`` at a time."""

    def __init__(self, limit: int) -> None:
        super().__init__()
        self._limit = limit
        self._n_uses = 0

    def check(self, name: str, use_id: UseId) -> None:
        """Refuse one use too many as a ``ProtocolError``."""
        if self._n_uses >= self._limit and use_id not in self.get(name, {}):
            raise ProtocolError(f"you have {self._n_uses} uses of topics, the limit")

    def add(self, name: str, use_id: UseId, value: V) -> None:
        """Note a use, in the place of one with the same identifier."""
        uses = self.setdefault(name, {})
        self._n_uses += use_id not in uses
        uses[use_id] = value

    def remove(self, name: str, use_id: UseId) -> bool:
        """Forget a use, or all of a topic without an identifier; return whether it was the last."""
        uses = self[name]
        for gone in tuple(uses) if use_id is None else {use_id} & uses.keys():
            del uses[gone]
            self._n_uses -= 1
        if not uses:
            del self[name]
        return not uses


class Budget:
    """Bytes that all clients share."""

    def __init__(self, limit: int) -> None:
        self._limit = limit
        self.used = 0

    def take(self, n_bytes: int) -> bool:
        """Use some; return whether there are as many left."""
        if self.used + n_bytes > self._limit:
            return False
        self.used += n_bytes
        return True

    def give_back(self, n_bytes: int) -> None:
        """Have used some."""
        self.used -= n_bytes


class Wish(NamedTuple):
    """What one ``subscribe`` asks for; ``throttle_s`` is the least time between two messages.

    Messages beyond ``queue_length`` that wait for their time are lost, the oldest first; with 0,
    what comes too early is lost.
    """

    throttle_s: float = 0.0
    queue_length: int = 0
    encoding: Encoding = PLAIN


def wish(operation: dict[str, Any]) -> Wish:
    """Return what a ``subscribe`` asks for; a value that makes no sense is a ``ProtocolError``."""
    throttle_ms = operation.get("throttle_rate", 0)
    queue_length = operation.get("queue_length", 0)
    if not 0 <= throttle_ms <= _LONGEST_THROTTLE_MS:
        raise ProtocolError(f"throttle_rate: expected 0 to {_LONGEST_THROTTLE_MS:g} ms")
    if queue_length < 0:
        raise ProtocolError("queue_length: expected 0 or more")
    return Wish(throttle_ms / 1000, min(queue_length, _LONGEST_QUEUE), wanted_encoding(operation))


def wanted_encoding(operation: dict[str, Any]) -> Encoding:
    """Return the encoding that an operation asks for; an unknown compression counts as none."""
    compression = operation.get("compression", "none")
    size = operation.get("fragment_size")
    if compression not in COMPRESSIONS:
        compression = "none"
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
    """One topic, as the client spells it, of one client, whatever number of times it subscribed.

    ``scheduler`` is the clock for throttling; ``budget`` is what the messages of all clients may
    take while they wait for their time.
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
