"""Requests of a client: operations, names, fragments, and options of a subscription.

``operations`` splits a text into JSON values, and ``check_operation`` checks the fields of one
against the table ``_FIELDS``. ``Fragments`` joins a message that arrives in parts. An
invalid request is a ``ProtocolError`` whose text is meant for the client.

``Uses`` are the topics that a client advertises or subscribes to. A ``Wish`` is the request of one
``subscribe``: rate, queue length and encoding. ``settled`` combines the
wishes of one client for one topic, and a ``Subscription`` delivers the topic accordingly.

The scheduler, an argument, provides the time. Begin with ``check_operation``.

References
----------
https://github.com/RobotWebTools/rosbridge_suite/blob/ros1/ROSBRIDGE_PROTOCOL.md
"""

import json
from asyncio import AbstractEventLoop, TimerHandle
from collections import deque
from collections.abc import Callable, Collection, Iterator
from types import MappingProxyType
from typing import Any, NamedTuple, TypeAlias, TypeVar

from mrsfi_bridge.errors import ProtocolError
from mrsfi_bridge.frames import COMPRESSIONS, PLAIN, Encoding, Outgoing, from_json

Operation: TypeAlias = dict[str, Any]

_MAX_SHOWN = 100
_LONGEST_ID = 256
_LONGEST_NAME = 256  # of a topic, a service or a parameter
_FRAGMENT_BYTES = 64  # what a fragment takes beside its letters
_MAX_UNFINISHED = 16


class _Field(NamedTuple):
    kinds: tuple[type, ...]
    is_required: bool = False


_NAME = _Field((str,), is_required=True)
_ID = _Field((str, int, type(None)))
_CALL = _Field((str, int), is_required=True)
_NUMBER = _Field((int,), is_required=True)
_FLAG = _Field((bool,))
_ARGUMENTS = _Field((dict, list, type(None)))
_ENCODING = {"fragment_size": _Field((int, type(None))), "compression": _Field((str,))}

_FIELDS = MappingProxyType(
    {
        "advertise": {"topic": _NAME, "type": _NAME, "latch": _FLAG, "id": _ID},
        "unadvertise": {"topic": _NAME, "id": _ID},
        "publish": {"topic": _NAME, "msg": _Field((dict,)), "latch": _FLAG, "id": _ID},
        "subscribe": {
            "topic": _NAME,
            "type": _Field((str, type(None))),
            "throttle_rate": _Field((int, float)),
            "queue_length": _Field((int,)),
            **_ENCODING,
            "id": _ID,
        },
        "unsubscribe": {"topic": _NAME, "id": _ID},
        "call_service": {
            "service": _NAME,
            "args": _ARGUMENTS,
            "timeout": _Field((int, float, type(None))),
            **_ENCODING,
            "id": _ID,
        },
        "service_response": {"service": _NAME, "id": _CALL, "result": _Field((bool, type(None)))},
        "advertise_service": {"service": _NAME, "type": _NAME, "id": _ID},
        "unadvertise_service": {"service": _NAME, "id": _ID},
        "advertise_action": {"action": _NAME, "type": _NAME, "id": _ID},
        "unadvertise_action": {"action": _NAME, "id": _ID},
        "send_action_goal": {
            "action": _NAME,
            "action_type": _NAME,
            "args": _ARGUMENTS,
            "feedback": _FLAG,
            **_ENCODING,
            "id": _ID,
        },
        "cancel_action_goal": {"action": _NAME, "id": _CALL},
        "action_feedback": {"action": _NAME, "id": _CALL},
        "action_result": {"action": _NAME, "id": _CALL, "status": _Field((int,)), "result": _FLAG},
        "set_level": {"level": _NAME, "id": _ID},
        "fragment": {"id": _CALL, "data": _NAME, "num": _NUMBER, "total": _NUMBER},
    }
)
"""Fields of each operation; others are ignored, as on the genuine server."""


def operations(text: str, refuse: Callable[[str], None]) -> Iterator[Any]:
    """Yield the JSON values of a frame, which may hold several.

    ``refuse`` gets the reason, once, if a part of the text is not JSON.
    """
    try:
        value = from_json(text)
    except (ValueError, RecursionError):
        yield from _several(text, refuse)
    else:
        yield value


def _several(text: str, refuse: Callable[[str], None]) -> Iterator[Any]:
    position, decoder = 0, json.JSONDecoder()
    while position < len(text):
        try:
            value, position = decoder.raw_decode(text, position)
        except (ValueError, RecursionError) as error:
            reason = str(error) if isinstance(error, ValueError) else "nested too deeply"
            refuse(f"bad JSON at character {position + 1} of {len(text)}: {reason:.{_MAX_SHOWN}}")
            return
        yield value
        while position < len(text) and text[position] in " \t\r\n":
            position += 1


def check_operation(value: Any) -> Operation:
    """Return an operation whose fields are of the right kind; ``ProtocolError`` if one is not."""
    if not isinstance(value, dict):
        raise ProtocolError(f"found {value!r:.{_MAX_SHOWN}}, expected an object with 'op'")
    op = value.get("op")
    fields = _FIELDS.get(op) if isinstance(op, str) else None
    if fields is None:
        known = ", ".join(_FIELDS)
        raise ProtocolError(f"unknown op {op!r:.{_MAX_SHOWN}}, expected one of {known}")
    for name, field in fields.items():
        if name not in value:
            if field.is_required:
                raise ProtocolError(f"{op}: field '{name}' is missing")
        elif type(value[name]) not in field.kinds:
            kinds = " or ".join(kind.__name__ for kind in field.kinds)
            raise ProtocolError(
                f"{op}: '{name}' is {value[name]!r:.{_MAX_SHOWN}}, expected {kinds}"
            )
    if len(str(value.get("id", ""))) > _LONGEST_ID:
        raise ProtocolError(f"{op}: 'id' is longer than {_LONGEST_ID} characters")
    return value


def absolute(name: str) -> str:
    """Return a name from the root, with one slash before each part."""
    if name.startswith("/") and "//" not in name and not name.endswith("/"):
        return name
    return "/" + "/".join(part for part in name.split("/") if part)


def check_name(name: str, noun: str) -> None:
    """Raise ``ProtocolError`` if a name is empty, too long, or has blanks or unprintable parts."""
    if name.strip("/") and len(name) <= _LONGEST_NAME and name.isprintable() and " " not in name:
        return
    shown = repr(name[:_LONGEST_NAME])
    expected = f"1 to {_LONGEST_NAME} printable characters without spaces"
    raise ProtocolError(f"{shown} is not a {noun} name; expected {expected}")


class _Unfinished(NamedTuple):
    """A message with missing fragments."""

    total: int
    parts: list[str]
    n_bytes: int


class Fragments:
    """Joins messages that arrive in fragments; unfinished ones share ``max_bytes``.

    The fragments of a message arrive in order. After a refused one, the rest of its
    message is refused, too, because the next accepted one must be the first of a message.
    """

    def __init__(self, max_bytes: int) -> None:
        self._max_bytes = max_bytes
        self._unfinished: dict[str | int, _Unfinished] = {}
        self.n_bytes = 0

    def add(self, fragment: Operation) -> str | None:
        """Take a fragment; return the message that it completes."""
        fragment_id, number, total = fragment["id"], fragment["num"], fragment["total"]
        message = self._forget(fragment_id) or _Unfinished(total, [], 0)
        if number >= total or (number, total) != (len(message.parts), message.total):
            expected = f"{len(message.parts)} of {message.total}"
            raise ProtocolError(f"fragment {number} of {total}, expected {expected}")
        if len(self._unfinished) >= _MAX_UNFINISHED:
            raise ProtocolError(
                f"the limit of {_MAX_UNFINISHED} incomplete messages in fragments is reached"
            )
        n_bytes = message.n_bytes + len(fragment["data"]) + _FRAGMENT_BYTES
        if self.n_bytes + n_bytes > self._max_bytes:
            raise ProtocolError(f"incomplete messages exceed {self._max_bytes} bytes, the limit")
        message.parts.append(fragment["data"])
        if len(message.parts) == total:
            return "".join(message.parts)
        self._unfinished[fragment_id] = message._replace(n_bytes=n_bytes)
        self.n_bytes += n_bytes
        return None

    def _forget(self, fragment_id: str | int) -> _Unfinished | None:
        """Remove and return the received part of a message."""
        message = self._unfinished.pop(fragment_id, None)
        self.n_bytes -= 0 if message is None else message.n_bytes
        return message


V = TypeVar("V")

UseId: TypeAlias = str | int | None  # identifies one of a client's uses of a topic
_LONGEST_THROTTLE_MS = 1e9


class Uses(dict[str, dict[UseId, V]]):
    """Topics that a client uses, each with the identifiers that the client gave."""

    def remove(self, name: str, use_id: UseId) -> bool:
        """Remove one use, or without an identifier all; return whether none remains."""
        uses = self[name]
        for gone in tuple(uses) if use_id is None else {use_id} & uses.keys():
            del uses[gone]
        if not uses:
            del self[name]
        return not uses


class Budget:
    """Bytes that all clients share."""

    def __init__(self, limit: int) -> None:
        self._limit = limit
        self.used = 0

    def take(self, n_bytes: int) -> bool:
        """Take bytes if the limit allows; return whether it does."""
        if self.used + n_bytes > self._limit:
            return False
        self.used += n_bytes
        return True

    def give_back(self, n_bytes: int) -> None:
        """Return bytes."""
        self.used -= n_bytes


class Wish(NamedTuple):
    """The request of one ``subscribe``; ``throttle_s`` is the least time between two messages.

    Early messages wait. Beyond ``queue_length``, the oldest are lost; with 0, all early ones.
    """

    throttle_s: float = 0.0
    queue_length: int = 0
    encoding: Encoding = PLAIN


def wish(operation: dict[str, Any]) -> Wish:
    """Return the request of a ``subscribe``; an invalid value is a ``ProtocolError``."""
    throttle_ms = operation.get("throttle_rate", 0)
    queue_length = operation.get("queue_length", 0)
    if not 0 <= throttle_ms <= _LONGEST_THROTTLE_MS:
        raise ProtocolError(f"throttle_rate: expected 0 to {_LONGEST_THROTTLE_MS:g} ms")
    if queue_length < 0:
        raise ProtocolError("queue_length: expected 0 or more")
    return Wish(throttle_ms / 1000, min(queue_length, 10_000), wanted_encoding(operation))


def wanted_encoding(operation: dict[str, Any]) -> Encoding:
    """Return the requested encoding; an unknown compression counts as none."""
    compression = operation.get("compression", "none")
    size = operation.get("fragment_size")
    if compression not in COMPRESSIONS:
        compression = "none"
    if size is not None and size <= 0:
        raise ProtocolError("fragment_size: expected more than 0")
    return Encoding(compression, size)


def settled(wishes: Collection[Wish]) -> Wish:
    """Combine wishes: the highest rate, the shortest queue, the best compression."""
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
    """One topic of one client, in its spelling, for all its subscriptions.

    ``scheduler`` is the clock for throttling; ``budget`` limits the bytes of waiting messages of
    all clients.
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
        """Send a message now, later or never, as requested."""
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
        """Drop the waiting messages."""
        while self._queue:
            self._take()
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None

    def _keep(self, frames: bytes) -> None:
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
