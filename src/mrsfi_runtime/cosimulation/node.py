"""An external node in place of the generated reactions.

The node acts between the two halves of the kernel's answer (``kernel.flight.hear`` and
``reply``). It receives the messages of a collective intelligence: none that a fault
withholds, and false values of those that a fault falsifies. It answers with commands.

Invariants: callbacks run in the transport's thread, ``begin`` and ``end`` in
another. No call waits longer than the patience allows. Errors of the node after it is ready
set ``is_to_blame``.

Begin with ``Node.begin``, ``answer`` and ``_hear``. ``node_mapping`` has the names that the node
uses, ``node_speech`` the content of its messages.
"""

from collections.abc import Callable, Sequence
from functools import partial
from time import monotonic, sleep
from typing import Any, Final

from mrsfi_runtime.cosimulation.bus_lockstep import Completion
from mrsfi_runtime.cosimulation.bus_topics import (
    ANSWER,
    BARRIER,
    CLOCK,
    SETUP,
    TICK,
    Pace,
    Patience,
    Setup,
)
from mrsfi_runtime.cosimulation.lockstep import Flight, Mind
from mrsfi_runtime.cosimulation.node_speech import Hearing, Held, Relay, Speech
from mrsfi_runtime.cosimulation.programs import KeptProcess
from mrsfi_runtime.errors import (
    MrsfiError,
    ProtocolError,
    TransportClosed,
    TransportTimeout,
    counted,
)
from mrsfi_runtime.kernel.commands import reports_position
from mrsfi_runtime.model.fault_types import SEMANTICS, Field
from mrsfi_runtime.model.faults import Target
from mrsfi_runtime.transport.topics import (
    PUBLISHERS,
    SUBSCRIBERS,
    TOPICS,
    NodeTransport,
    Payload,
    Publisher,
    Reply,
    Service,
    Topic,
    time_of,
)

_LOOK = 0.1
_STEADY = 0.3  # seconds without a new subscription after which a node counts as ready
_FLOOD: Final = 1000  # most commands of a node on a topic in a tick


class Node(Mind):
    """A node behind a transport, for the flights of one mission, one after the other.

    Its callbacks run in the transport's thread; ``begin`` and ``end`` in another. A ``process`` is
    started before the first flight, or for each. After an error, ``is_to_blame`` says whether the
    node caused it after it was ready. ``held`` are the faults of the next flight that hold back
    relayed commands.
    """

    def __init__(
        self,
        transport: NodeTransport,
        speech: Speech,
        pace: Pace,
        patience: Patience,
        process: KeptProcess | None = None,
    ) -> None:
        self._transport = transport
        self.speech = speech
        self._mapping = speech.mapping
        self._pace = pace
        self._patience = patience
        self._process = process
        self._restarts = process is not None and process.restarts
        self.is_to_blame = False
        self.held: Sequence[Held] = ()
        self._sayings = [(each, transport.advertise(each.topic)) for each in speech.sayings]
        self._sent: list[tuple[Any, ...] | None] = []
        self._ready: frozenset[str] | None = None
        self._has_flown = False
        self._flight: Flight | None = None
        self._run = self._tick = 0
        self._has_answered = False
        self._then: Callable[[], None] | None = None
        self._n_heard: dict[str, int] = {}
        self._n_answered: int | None = None
        self._n_obeyed = 0
        self._setup = transport.advertise(SETUP)
        self._publish_tick = transport.advertise(TICK)
        self._clock = transport.advertise(CLOCK)
        for each in speech.hearings:
            transport.subscribe(each.topic, partial(self._hear, each))
        self._relay = Relay({})
        if pace.kind == ANSWER:
            transport.subscribe(speech.mapping.answer, self._hear_answer)

    def pass_on(self, advertise: Callable[[Topic], Publisher]) -> None:
        """Relay commands other than heading and speed to the topics of a world."""
        self._relay = Relay(
            {each.topic.name: (each.robot, advertise(each.world)) for each in self.speech.relayed}
        )
        for each in self.speech.relayed:
            self._transport.subscribe(each.topic, partial(self._pass_on_later, each.topic.name))

    def begin(self, flight: Flight, run: int, seed: int) -> None:
        """Return the node to before tick 0, and wait until it is ready.

        If that takes too long, it is a ``TransportTimeout``.
        """
        self._flight, self._run, self._then = flight, run, None
        self.is_to_blame = self._has_answered = False
        self._relay.begin(self.held)
        self._sent = [None] * len(self._sayings)
        self._n_obeyed = 0
        deadline = monotonic() + self._patience.handshake
        is_new = self._ready is None
        if self._process is not None and self._process.is_due:
            self._process.stop()
            gone = monotonic() + 2.0  # or another client subscribes, too
            while self._joined() and monotonic() < gone:
                sleep(_LOOK / 2)
            self._process.start(seed)
            is_new, self._has_flown = True, False
        if is_new:  # before the reset: ROS 1 lets a call to a service wait whose node was killed
            self._await_node(deadline)
        if not self._restarts:
            self._reset(run, seed, deadline)
        if is_new:
            self._shake_hands()
        if self._restarts:
            self._set_up(run, seed)
        self._pace.begin()
        self._has_flown = True

    def answer(self, flight: Flight, tick: int, then: Callable[[], None]) -> bool:
        """Send the node the messages of a tick; call a function when it has answered."""
        self._pace.settle()
        self._tick, self._then = tick, then
        self._n_heard = dict.fromkeys(self._n_heard, 0)
        self._n_answered = None
        self._tell_time(tick)
        n_sent = self._publish(flight, tick)
        self._clock({"clock": time_of(tick, self._transport.ros)})
        self._publish_tick({"data": [self._run, tick, n_sent, self._n_obeyed]})
        self._pace.wait(self._transport, tick, self._answered)
        return False

    def soon(self, function: Callable[[], None]) -> None:
        """Call a function in the thread of the callbacks."""
        self._transport.call_later(0.0, function)

    def overdue(self, silence: float) -> MrsfiError | None:
        """Return the error, if any, after so many seconds without progress."""
        if (ended := self._ended()) is not None:
            return ended
        if silence <= self._patience.tick or self._pace.is_free:
            return None
        self.is_to_blame = True
        awaited = self._pace.awaited(self._mapping.answer.name)
        if self._n_answered is not None:
            awaited = f"{self._n_answered} commands, as announced; {self._n_now} arrived"
        elif self._pace.kind == ANSWER and "answer" not in self._mapping.table:
            awaited += (
                "; if it answers on another topic, name that topic as answer in [node] of "
                "mrsfi.toml; if it answers on none, set a rate with --node-pace RATE"
            )
        unheard = ""
        if self._pace.kind == ANSWER and not self._tick:
            silent = {self._mapping.answer.name} if self._n_answered is None else set()
            silent |= self.speech.obeyed - self._n_heard.keys()
            unheard = f"; nothing arrived on {', '.join(sorted(silent))}, {self._transport.hint}"
        return TransportTimeout(
            f"the node was silent for {self._patience.tick:g} s; expected {awaited}; check that "
            f"it still runs, or increase --timeout{unheard}"
        )

    def end(self) -> None:
        """Finish a flight; commands to robots that the mission does not have are an error."""
        self._flight = self._then = None
        heard = {each.topic.name for each, _ in self._sayings}
        was = (self._ready or frozenset()) & heard
        lost = was - self._joined() if self._pace.is_free else None
        if lost:  # at a rate, no answer is missing
            raise self._wrong(
                f"the node no longer subscribes to {', '.join(sorted(lost))}; expected it to stay "
                "connected and subscribed until it is stopped"
            )
        topics = self._ask(TOPICS, {}).values.get("topics", ())
        for topic, kind, name in self.speech.strangers(topics):
            elements = self._mapping.elements(self.speech.mission)
            known = ", ".join(each.name for each in elements if each.kind == kind)
            raise self._wrong(
                f"the node commands {kind} '{name}' on {topic}; the mission has {known}; "
                "correct the node, or names in [node]"
            )

    def refuse(self, topic: str, reason: str) -> None:
        """Take the refusal of a message of the node, with its topic if known."""
        is_flying = self._flight is not None and self._has_flown
        if is_flying and topic in self.speech.obeyed | {"", self._mapping.answer.name}:
            raise self._wrong(f"the server refused a message of the node: {reason}")

    def _wrong(self, text: str) -> ProtocolError:
        self.is_to_blame = True
        return ProtocolError(text)

    def _publish(self, flight: Flight, tick: int) -> int:
        """Publish values that the world sent and no fault withholds, and changed beliefs."""
        ci, sent = flight.belief, self._sent
        silent = self._silent(flight, tick)
        n_sent = 0
        for number, (saying, publish) in enumerate(self._sayings):
            values = saying.values(ci)
            if values != sent[number] or not saying.spoken <= silent:  # or the world sent it
                sent[number] = values
                message = saying.payload(values)
                if saying.is_stamped:
                    message["header"]["stamp"] = time_of(tick, self._transport.ros)
                publish(message)
                n_sent += 1
        return n_sent

    def _tell_time(self, tick: int) -> None:
        """Publish the time between the last tick and this one, for timers of the node."""
        n_steps = self._mapping.clock_hz
        for step in range(1, n_steps if tick else 0):
            self._clock({"clock": time_of(tick - 1, self._transport.ros, step / n_steps)})

    def _silent(self, flight: Flight, tick: int) -> set[Target]:
        """Return the properties about which no message arrives in this tick."""
        silent: set[Target] = {
            (Field.POSITION, index)
            for index in range(len(flight.world.robots))
            if not reports_position(flight.world, index)
        }
        for injection in flight.plan.messages:
            if injection.start <= tick <= injection.finish:
                silent.add((Field(injection.affected), injection.target))
        return silent

    def _hear(self, hearing: Hearing, message: Payload) -> None:
        if self._flight is not None:
            ci = self._flight.belief
            self._take(hearing.topic.name, lambda: hearing.obey(ci, message))

    def _pass_on_later(self, name: str, message: Payload) -> None:
        if self._flight is not None:
            self._take(name, lambda: self._relay.take(name, message))

    def _take(self, name: str, obey: Callable[[], None]) -> None:
        n_heard = self._n_heard[name] = self._n_heard.get(name, 0) + 1
        if n_heard > _FLOOD and not self._pace.is_free:
            raise self._wrong(f"{name}: the node sent more than {_FLOOD} commands in a tick")
        self._n_obeyed += 1
        if self._then is None and self._has_answered and self._pace.kind == BARRIER:
            raise ProtocolError(
                f"{name}: a command came after the node had answered tick {self._tick}; expected "
                "a node that receives and commands in one thread, or --node-pace answer or a rate"
            )
        try:
            obey()
        except ProtocolError as error:
            raise self._wrong(str(error)) from error
        if self._n_answered is not None:
            self._answer_when_complete()

    def _hear_answer(self, message: Payload) -> None:
        """Take the answer to a tick; if it has numbers, they are ``[tick, commands]``."""
        if self._flight is None or self._then is None:
            return
        name, numbers = self._mapping.answer.name, message.get("data")
        if self._mapping.answer.type != "std_msgs/Int64MultiArray":
            self._answered()
            return
        if not (
            isinstance(numbers, list)
            and len(numbers) == 2
            and all(type(number) is int for number in numbers)
            and numbers[0] == self._tick
        ):
            raise self._wrong(
                f"{name} carried {numbers!r}; expected [tick, commands], here [{self._tick}, "
                f"{self._n_now}]"
            )
        self._n_answered = numbers[1]
        self._answer_when_complete()

    @property
    def _n_now(self) -> int:
        return sum(self._n_heard.values())

    def _answer_when_complete(self) -> None:
        expected, n_now = self._n_answered, self._n_now
        if expected is not None and n_now > expected:
            raise self._wrong(
                f"{counted(n_now, 'commands')} arrived in a tick; the node announced {expected}"
            )
        if n_now == expected:
            self._answered()

    def _answered(self) -> None:
        then, self._then, self._n_answered = self._then, None, None
        self._has_answered = True
        if then is not None and self._flight is not None:
            self._relay.pass_on(self._flight.plan, self._tick)
            then()

    def _set_up(self, run: int, seed: int) -> None:
        self._setup({"data": [*Setup(run, seed, SEMANTICS)]})

    def _reset(self, run: int, seed: int, deadline: float) -> None:
        """Return the node to before tick 0; ask again while the service does not exist."""
        is_overtaken = False
        while True:
            self._set_up(run, seed)
            reply = self._ask(self._mapping.reset, {})
            answer = reply.problem or str(reply.values.get("message", ""))
            if reply.values.get("success"):
                if not answer.startswith("run ") or answer == f"run {run}":
                    return
                if is_overtaken:
                    sleep(_LOOK)
                is_overtaken = True  # the reset came before the setup, as on a server of ROS 2
            self._require_alive()
            if monotonic() > deadline:
                raise TransportTimeout(
                    f"the node did not reset within {self._patience.handshake:g} s: "
                    f"{self._mapping.reset.name}: {answer or 'no success'}; check that it runs, "
                    f"or increase --timeout; {self._transport.hint}"
                )
            if not reply.values.get("success"):
                sleep(_LOOK)

    def _await_node(self, deadline: float) -> None:
        """Wait until the node has joined the topics of the flight before, or joins no more."""
        heard = frozenset(each.topic.name for each, _ in self._sayings)
        before: frozenset[str] = frozenset()
        steady = monotonic()
        while True:
            joined = self._joined()
            if joined != before:
                before, steady = joined, monotonic()
            if self._ready is not None and joined >= self._ready:
                return
            if self._ready is None and joined & heard and monotonic() - steady > _STEADY:
                self._ready = joined
                return
            self._require_alive()
            if monotonic() > deadline:
                missing = ", ".join(sorted((self._ready or heard) - joined))
                raise TransportTimeout(
                    f"the node subscribed to {'not every' if joined else 'no'} topic within "
                    f"{self._patience.handshake:g} s; no subscriber to {missing}; check [node] in "
                    f"mrsfi.toml, or increase --timeout; {self._transport.hint}"
                )
            sleep(_LOOK / 2)

    def _shake_hands(self) -> None:
        """Wait until the node answers, before tick 0."""
        completion, timeout = Completion(), self._patience.tick
        if self._pace.kind == BARRIER:
            self._pace.wait(self._transport, 0, completion.end)
            awaited = self._pace.awaited("")
            late = TransportTimeout(
                f"the node was silent for {timeout:g} s before tick 0; expected {awaited}; check "
                "that it still runs, or increase --timeout"
            )
            completion.wait(lambda silence: self._ended() or (late if silence > timeout else None))

    def _require_alive(self) -> None:
        """Raise an error if the node's process has ended."""
        ended = self._ended()
        if ended is not None:
            raise ended

    def _ended(self) -> TransportClosed | None:
        """Return that the node's process has ended; once it was ready, it is to blame."""
        ended = None if self._process is None else self._process.ended()
        self.is_to_blame |= ended is not None and self._has_flown
        return ended

    def _joined(self) -> frozenset[str]:
        """Return the topics that the node has joined: those that it receives, and commands."""
        ends = [(SUBSCRIBERS, "subscribers", each.topic.name) for each, _ in self._sayings]
        ends += [(PUBLISHERS, "publishers", name) for name in self.speech.obeyed]
        return frozenset(
            name
            for service, found, name in ends
            if self._ask(service, {"topic": name}).values.get(found)
        )

    def _ask(self, service: Service, request: Payload) -> Reply:
        """Call a service once and wait for its reply."""
        completion, timeout = Completion(), self._patience.tick
        self._transport.call(service, request, completion.end)
        late = TransportTimeout(
            f"{service.name} did not answer within {timeout:g} s; check that the node still "
            "runs, or increase --timeout"
        )
        reply: Reply = completion.wait(
            lambda silence: self._ended() or (late if silence > timeout else None)
        )
        return reply
