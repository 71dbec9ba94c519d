"""The topics of a lock-step over a bus, and the checks of their messages.

The collective intelligence (CI) sends ``SETUP`` before it resets the simulation, and ``GO``
after the commands that precede a tick's motion: all of them before tick 0, later those that
changed. The simulation answers with the messages of the tick, and ``TICK`` last.

Invariant: a lost, duplicated or reordered message is always detected. ``GO`` and
``TICK`` contain the number of messages before them, and ``TICK`` also the number of commands that
the simulation obeyed: a server that keeps order only within a topic may deliver ``GO`` before its
commands. ``CountedTopics`` compares these numbers with the messages that arrived.

Begin with ``CountedTopics``. If both sides support it, ``BundlingTransport`` sends the messages of
a tick as one, for speed: a JSON list of ``[topic, message]`` pairs in the order of publication.
A ``Pace`` decides when an external node has answered a tick.
"""

import json
import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from time import monotonic
from typing import Any, Final, NamedTuple, TypeVar

from mrsfi_runtime.errors import MrsfiError, ProtocolError, TransportError, TransportTimeout
from mrsfi_runtime.transport.topics import (
    SEE_LOG,
    NodeTransport,
    Payload,
    Publisher,
    PubSub,
    Service,
    Topic,
    Transport,
    seconds_of,
)

# CI to simulation
SETUP = Topic("/mission/setup", "std_msgs/Int64MultiArray")  # the next reset's run, a ``Setup``
GO = Topic("/mission/go", "std_msgs/Int64MultiArray")  # fly a tick, a ``Go``
GO_BUNDLE = Topic("/mission/go/bundle", "std_msgs/String")  # ``GO`` and all that goes before it

# Simulation to CI
TICK = Topic("/mission/tick", "std_msgs/Int64MultiArray")  # a tick was flown, a ``Tick``
TICK_BUNDLE = Topic("/mission/tick/bundle", "std_msgs/String")  # ``TICK`` and all before it
CLOCK = Topic("/clock", "rosgraph_msgs/Clock")  # to all: one tick is one second
FAILURE = Topic("/mission/failure", "std_msgs/String")  # why it cannot continue

RESET = Service("/mission/reset", "std_srvs/Trigger")
"""Return to before tick 0, with the newest setup; answers ``run <run>``.

A simulation of another semantics version answers with ``REFUSAL`` first, and ends with an error
if no request of its version follows.
"""

REFUSAL = "semantics"
"""Begins an answer that repetition does not change; the simulation's version follows."""

STOP = Service("/mission/stop", "std_srvs/Trigger")  # ends the run

RUNS_OF_A_SESSION = 1_000_000
"""A run has the number session × this + its place in the session, from 1 on.

The session is drawn at random, so messages of another collective intelligence, or of a leftover
simulation, are recognized as foreign.
"""


class Setup(NamedTuple):
    """Numbers of ``SETUP``."""

    run: int
    seed: int
    semantics: int


class Go(NamedTuple):
    """Numbers of ``GO``; ``n_commands`` were sent in this tick before it."""

    run: int
    tick: int
    n_commands: int


class Tick(NamedTuple):
    """Numbers of ``TICK``.

    ``n_messages`` were sent in this tick before it; ``n_commands`` were obeyed since the reset. A
    simulator that cannot be stepped adds ``n_late``: the commands of this tick that came after it
    had moved on.
    """

    run: int
    tick: int
    n_messages: int
    n_commands: int
    n_late: int = 0


Numbers = TypeVar("Numbers", Setup, Go, Tick)


def numbers(topic: Topic, payload: Payload, kind: type[Numbers]) -> Numbers:
    """Return the numbers of a message of the lock-step.

    Another number of values, or values of another type, are a ``ProtocolError``.
    """
    values, n_most = payload.get("data"), len(kind._fields)
    n_least = n_most - len(kind._field_defaults)
    if (
        not isinstance(values, list)
        or not n_least <= len(values) <= n_most
        or not all(type(value) is int for value in values)
    ):
        raise ProtocolError(
            f"{topic.name} carried {values!r}; expected {n_least} integers: "
            f"{', '.join(kind._fields[:n_least])} (docs/bus.md)"
        )
    return kind(*values)


GRACE = 1.0
"""Seconds for which announced messages may be late: some servers keep order per topic only."""


def _are_numbers(*values: Any) -> bool:
    return all(type(each) in (int, float) and abs(each) <= sys.float_info.max for each in values)


def _is_integer(value: Any) -> bool:
    return type(value) is int and abs(value) < 2**63


_FORMS: Final[Mapping[str, Callable[[Payload], bool]]] = {
    "geometry_msgs/Point": lambda payload: _are_numbers(*(payload[axis] for axis in "xyz")),
    "geometry_msgs/Vector3": lambda payload: _are_numbers(*(payload[axis] for axis in "xyz")),
    "rosgraph_msgs/Clock": lambda payload: _is_integer(seconds_of(payload["clock"])),
    "std_msgs/Bool": lambda payload: type(payload["data"]) is bool,
    "std_msgs/Float64": lambda payload: _are_numbers(payload["data"]),
    "std_msgs/Float64MultiArray": lambda payload: _are_numbers(*payload["data"]),
    "std_msgs/Int64": lambda payload: _is_integer(payload["data"]),
}
"""Whether a message is of its type, its numbers finite and not NaN: not every server checks."""


class CountedTopics:
    """The topics of generated code on one side of a run; counts all messages in and out.

    Each topic carries at most one message per tick. The last message of a tick announces their
    number; ``proceed`` is called when a late one completes an announced tick. Messages of ``tick``
    are expected; ``n_before`` arrived in earlier ticks, ``n_sent`` were published in the run.
    Unless ``is_open``, received messages are not counted. While ``is_muted``, published ones are
    dropped, because no tick follows.
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
        self.tick = self.n_before = self.n_sent = self._n_announced = 0
        self.is_open, self.is_muted = True, False
        self._forget()

    def close(self) -> None:
        """End the run."""
        self.is_open = False

    def advertise(self, topic: Topic) -> Publisher:
        """Return a function that publishes on a topic and counts."""
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
        """Count a received message; return whether it completes its tick."""
        if not self.is_open:
            return False
        if topic in self._received:
            raise ProtocolError(f"two messages arrived on {topic} in one tick; expected one")
        self._received.add(topic)
        return self._is_complete()

    def announced(self, tick: int, n_messages: int) -> bool:
        """Take the number of messages of a tick; return whether all of them have arrived."""
        if tick != self.tick or self._n_expected is not None:
            raise ProtocolError(
                f"the {self._sender} announced tick {tick}; expected tick "
                f"{self.tick + (self._n_expected is not None)}: "
                "messages were lost, duplicated or reordered"
            )
        self._n_expected = n_messages
        return self._is_complete()

    def turn(self) -> None:
        """Go on to the next tick."""
        self.tick += 1
        self.n_before += len(self._received)
        self._forget()

    def announce(self) -> int:
        """Return the number of messages published since the last call."""
        n_before, self._n_announced = self._n_announced, self.n_sent
        return self.n_sent - n_before

    def overdue(self, silence: float, timeout: float) -> MrsfiError | None:
        """Return the error, if any, after so many seconds without progress."""
        if not self.is_open:
            return None
        silent = ", ".join(sorted(self._topics - self._received))
        if self._n_expected is not None and silence > GRACE:
            what = "it flies another mission, with more topics"
            if silent:
                lost = f"none on {silent}: a message was lost"
                what = lost if self.tick else f"{lost}, or {SEE_LOG}"
            elif self.tick:
                what = "it counted a message that it did not send, or one was lost"
            return TransportError(
                f"{len(self._received)} of {self._n_expected} messages from the {self._sender} "
                f"arrived; {what}"
            )
        if silence > timeout:
            silent = silent or "the topic that ends a tick"
            unheard = "" if self.tick else f"; nothing arrived on {silent}, {SEE_LOG}"
            return TransportTimeout(
                f"the {self._sender} was silent for {timeout:g} s; check that it still runs, "
                f"or increase --timeout{unheard}"
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
                f"{len(self._received)} messages from the {self._sender} arrived; it announced "
                f"{self._n_expected}: a message was duplicated or reordered"
            )
        return True


_encode = json.JSONEncoder(allow_nan=False, separators=(",", ":")).encode


class BundlingTransport:
    """A transport that can send all messages of a tick as one.

    That of the CI bundles from the start. That of a simulation answers bundles with bundles and
    messages with messages.
    """

    def __init__(self, transport: Transport, *, is_ci: bool) -> None:
        of_ci, of_simulation = (GO, GO_BUNDLE, TICK_BUNDLE), (TICK, TICK_BUNDLE, GO_BUNDLE)
        self._closing, sends, self._hears = of_ci if is_ci else of_simulation
        self._transport = transport
        self.provide, self.call = transport.provide, transport.call
        self.watch, self.close = transport.watch, transport.close
        self.ros = transport.ros
        self._is_first = self._is_bundling = is_ci
        self._waiting: list[tuple[str, Payload]] = []
        self._callbacks: dict[str, Callable[[Payload], None]] = {}
        self._send = transport.advertise(sends)
        transport.subscribe(self._hears, self._receive)

    def advertise(self, topic: Topic) -> Publisher:
        """Return the function that publishes on a topic, alone or in the bundle of its tick."""
        publish_alone = self._transport.advertise(topic)
        is_alone = topic in {SETUP, FAILURE}  # which belong to no tick
        is_closing = topic == self._closing

        def publish(payload: Payload) -> None:
            if is_alone:
                self._waiting.clear()  # of a run that came to its end
            if is_alone or not self._is_bundling:
                publish_alone(payload)
                return
            self._waiting.append((topic.name, payload))
            if is_closing:
                pairs, self._waiting = self._waiting, []
                self._send({"data": _encode(pairs)})

        return publish

    def subscribe(self, topic: Topic, callback: Callable[[Payload], None]) -> None:
        """Have a callback receive every message of a topic, bundled or not; one per topic."""

        def receive(payload: Payload) -> None:
            self._is_bundling = self._is_first
            callback(payload)

        self._callbacks[topic.name] = callback
        self._transport.subscribe(topic, receive)

    def _receive(self, payload: Payload) -> None:
        """Unpack a bundle; messages without a subscriber are ignored."""
        self._is_bundling = True
        text: Any = payload.get("data")
        try:
            pairs = [(str(name), dict(message)) for name, message in json.loads(text)]
        except (TypeError, ValueError) as error:
            raise ProtocolError(
                f"{self._hears.name} carried {str(text)[:80]!r}; expected a JSON list of "
                "[topic, message] pairs"
            ) from error
        for name, message in pairs:
            callback = self._callbacks.get(name)
            if callback is not None:
                callback(message)


@dataclass(frozen=True, slots=True)
class Patience:
    """Seconds that one side waits for the other, during a tick and before tick 0."""

    tick: float = 10.0
    handshake: float = 30.0


ANSWER, BARRIER = "answer", "barrier"
"""The node publishes an answer, or it answers pings sent after the messages of the tick."""

PACES = (ANSWER, BARRIER)


class Pace:
    """``answer``, ``barrier``, or a rate in ticks a second, which waits for no answer.

    The argument ``barrier`` calls a function when the node has answered pings, or another
    ``question``, sent after its messages; ``settle`` takes what has arrived since.
    """

    def __init__(
        self,
        kind: str,
        barrier: Callable[[Callable[[], None]], None] | None = None,
        settle: Callable[[], None] = lambda: None,
        question: str = "pings",
    ) -> None:
        self.kind = kind
        self.settle = settle
        self._barrier = barrier
        self._question = question
        self._start = 0.0

    @property
    def is_free(self) -> bool:
        """Whether the node runs by its own clock, so that a flight may not repeat itself."""
        return self.kind not in PACES

    def begin(self) -> None:
        """Begin a flight: tick 0 begins now."""
        self._start = monotonic()

    def wait(self, transport: NodeTransport, tick: int, then: Callable[[], None]) -> None:
        """Call a function when a tick is over, except for ``answer``."""
        if self.is_free:
            due = self._start + (tick + 1) / float(self.kind)
            transport.call_later(max(due - monotonic(), 0.0), then)
        elif self._barrier is not None and self.kind == BARRIER:
            self._barrier(then)

    def awaited(self, answer: str) -> str:
        """Return the awaited event in words."""
        return f"a message on {answer}" if self.kind == ANSWER else f"answers to {self._question}"
