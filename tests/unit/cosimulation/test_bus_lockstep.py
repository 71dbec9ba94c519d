"""The two sides of a mission over a bus: same results, and no message lost unseen."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from queue import SimpleQueue
from threading import Thread
from time import sleep

import pytest

from mrsfi_runtime.cosimulation import bus_lockstep
from mrsfi_runtime.cosimulation.bus_lockstep import BusLockstep, SimulationHost
from mrsfi_runtime.cosimulation.bus_topics import Patience
from mrsfi_runtime.cosimulation.lockstep import Mind
from mrsfi_runtime.engine.flights import ReferenceEngine
from mrsfi_runtime.errors import (
    EvaluationError,
    ProtocolError,
    TransportClosed,
    TransportError,
    TransportTimeout,
)
from mrsfi_runtime.generated_code import MissionCode
from mrsfi_runtime.model.fault_types import SEMANTICS
from mrsfi_runtime.transport.topics import (
    FailureListener,
    LocalBus,
    Payload,
    Provider,
    Publisher,
    Reply,
    Service,
    Topic,
)
from tests.support.trace import traced
from tests.support.two_sides import BusEngine
from tests.support.world import paper_code, specification

PATIENCE = Patience(tick=2.0, handshake=5.0)
Message = tuple[str, Payload]
Tamper = Callable[[Message], list[Message]]
"""What becomes of a message: nothing, itself, itself twice, others."""
CODE = paper_code(60)
HASTY = Patience(tick=0.5, handshake=5.0)
SPEED, GO, TICK, HEADING = "/r2/speed", "/mission/go", "/mission/tick", "/r1/command/heading"


class QueuedBus:
    """The server of the bus: a queue and a thread that empties it."""

    def __init__(self, tamper: Tamper | None = None) -> None:
        self._tamper = tamper or (lambda message: [message])
        self._queue: SimpleQueue[Callable[[], None] | None] = SimpleQueue()
        self.bus = LocalBus()
        self._publishers: dict[str, Publisher] = {}
        self._thread = Thread(target=self._empty)
        self._thread.start()

    def join(self) -> "QueuedTransport":
        """Return a transport of this bus."""
        return QueuedTransport(self)

    def advertise(self, topic: Topic) -> Publisher:
        """Return what puts a message into the queue."""
        self._publishers[topic.name] = self.bus.advertise(topic)

        def deliver(payload: Payload) -> None:
            for name, content in self._tamper((topic.name, payload)):
                self._publishers[name](content)

        return lambda payload: self._queue.put(lambda: deliver(payload))

    def put(self, work: Callable[[], None]) -> None:
        """Have the thread do something in turn."""
        self._queue.put(work)

    def close(self) -> None:
        """End the thread."""
        self._queue.put(None)
        self._thread.join()

    def _empty(self) -> None:
        while (work := self._queue.get()) is not None:
            work()


class QueuedTransport:
    """One side's connection to the bus; it can be cut."""

    ros = 1

    def __init__(self, bus: QueuedBus) -> None:
        self._bus = bus
        self._listener: FailureListener = _raise
        self._is_cut = False

    def advertise(self, topic: Topic) -> Publisher:
        publish = self._bus.advertise(topic)

        def publish_if_connected(payload: Payload) -> None:
            if self._is_cut:
                raise TransportClosed("cut")
            publish(payload)

        return publish_if_connected

    def subscribe(self, topic: Topic, callback: Callable[[Payload], None]) -> None:
        def receive(payload: Payload) -> None:
            try:
                callback(payload)
            except Exception as error:  # noqa: BLE001 - the listener decides
                self._listener(error)

        self._bus.bus.subscribe(topic, receive)

    def provide(self, service: Service, provider: Provider) -> None:
        self._bus.bus.provide(service, provider)

    def call(self, service: Service, request: Payload, on_reply: Callable[[Reply], None]) -> None:
        if self._is_cut:
            raise TransportClosed("cut")
        self._bus.put(lambda: self._bus.bus.call(service, request, on_reply))

    def watch(self, listener: FailureListener) -> None:
        self._listener = listener

    def close(self) -> None:
        """Do nothing: the bus is closed as a whole."""

    def cut(self) -> None:
        """Lose the connection."""
        self._is_cut = True
        self._listener(TransportClosed("cut"))


def _raise(error: Exception) -> None:
    raise error


@contextmanager
def sides(
    code: MissionCode,
    tamper: Tamper | None = None,
    patience: Patience = PATIENCE,
    patience_of_ci: Patience | None = None,
    mind: Mind | None = None,
    tell: Callable[[str], None] = lambda _: None,
) -> Iterator[tuple[SimulationHost, BusLockstep, QueuedTransport]]:
    """Yield the two sides of a mission on a bus, and the transport of the CI."""
    bus = QueuedBus(tamper)
    simulation = SimulationHost(bus.join(), code.simulation, code.mission, patience, tell)
    transport = bus.join()
    try:
        yield (
            simulation,
            BusLockstep(
                transport,
                code.mission,
                code.interface,
                code.truth,
                patience_of_ci or patience,
                mind,
            ),
            transport,
        )
    finally:
        bus.close()


def nth(topic, n, change):
    """Return a tamper that changes what becomes of the n-th message of a topic, from 0."""
    seen = []

    def tamper(message):
        if message[0] != topic:
            return [message]
        seen.append(message)
        return change(message) if len(seen) == n + 1 else [message]

    return tamper


def numbers(change):
    """Return what becomes of a message of numbers, given how they change."""
    return lambda message: [(message[0], {"data": change(*message[1]["data"])})]


def other_command(message):
    """Return what another collective intelligence says on the same topics, in mid-run."""
    run, tick, _ = message[1]["data"]
    return [(HEADING, {"x": 0.0, "y": -1.0, "z": 0.0}), (GO, {"data": [run + 1_000_000, tick, 1]})]


def flown(tamper=None, specification=(), code=CODE, patience=PATIENCE):
    """Return the outcome of a flight over a bus on which messages are tampered with."""
    with sides(code, tamper, patience) as (_, lockstep, _):
        return BusEngine(code, 1, lockstep).evaluate(specification)


def flown_in_process(specification=(), code=CODE):
    return ReferenceEngine(code, 1).evaluate(specification)


@contextmanager
def served(simulation):
    """Serve in a thread until the simulation fails; yield its errors."""
    ended = []

    def serve():
        try:
            simulation.serve()
        except TransportError as error:
            ended.append(str(error))

    thread = Thread(target=serve)
    thread.start()
    yield ended
    thread.join()


def lose(_message):
    return []


def double(message):
    return [message, message]


def test_runs_over_a_bus_equal_runs_in_process_tick_by_tick():
    reference = ReferenceEngine(CODE, 5)
    with sides(CODE) as (_, lockstep, _):
        engine = BusEngine(CODE, 5, lockstep)
        for seed in range(4):
            faults = specification(CODE, seed)

            assert traced(engine, faults) == traced(reference, faults)


def test_missions_of_one_tick_fly():
    code = paper_code(1)

    assert flown(code=code) == flown_in_process(code=code)


@pytest.mark.parametrize(
    ("tamper", "problem"),
    [
        (nth(SPEED, 17, lose), r"17: 1\d of \d\d messages .* none on .*/r2/speed"),
        (nth(SPEED, 17, double), "17: two messages arrived on /r2/speed"),
        (nth(TICK, 17, lose), "17: the simulation was silent for 0.5 s"),
        (nth(TICK, 17, double), "18: the simulation announced tick 17; expected tick 18"),
        (nth(GO, 17, lose), "17: the simulation was silent for 0.5 s"),
        (
            nth(TICK, 17, numbers(lambda run, _tick, *counts: [run, 19, *counts])),
            "17: the simulation announced tick 19; expected tick 17",
        ),
        (
            nth(TICK, 17, numbers(lambda run, tick, *counts: [run, str(tick), *counts])),
            r"17: /mission/tick carried .* expected 4 integers: .* \(docs/bus\.md\)",
        ),
        (
            nth(TICK, 0, numbers(lambda *found: found[:3])),
            r"0: /mission/tick carried .* expected 4 integers: .* \(docs/bus.md\)",
        ),
        (
            nth(TICK, 17, numbers(lambda *found: [*found[:3], found[3] - 1])),
            r"17: the simulation flew after \d+ commands; \d+ were sent .*docs/bus.md",
        ),
        (
            nth(TICK, 17, numbers(lambda *found: [*found[:3], found[3] + 1])),
            r"17: the simulation flew after \d+ commands; \d+ were sent .*docs/bus.md",
        ),
        (
            nth(TICK, 17, numbers(lambda run, *rest: [run % 1_000_000, *rest])),
            "17: the simulation was silent for 0.5 s",
        ),
        (
            nth(GO, 17, numbers(lambda run, *rest: [run % 1_000_000, *rest])),
            "17: the simulation was silent for 0.5 s",
        ),
        (
            nth(SPEED, 17, lambda _: [(SPEED, {"data": None})]),
            r"17: /r2/speed carried .*None.; expected std_msgs/Float64 of finite numbers",
        ),
        (
            nth("/truth/r1", 17, lambda _: [("/truth/r1", {"data": [1.0]})]),
            "17: /truth/r1 carried .1.0.; expected 9 numbers",
        ),
    ],
)
def test_what_goes_wrong_on_the_way_to_the_ci_is_told_with_its_tick(tamper, problem):
    patience = HASTY if "silent" in problem else PATIENCE
    with pytest.raises(TransportError, match=f"run 1, tick {problem}"):
        flown(tamper, patience=patience)


@pytest.mark.parametrize(
    ("tamper", "problem"),
    [
        (
            nth(HEADING, 0, lose),
            r"\d+ messages from the collective intelligence or node arrived; none on .*/r1/command",
        ),
        (nth(HEADING, 0, double), "two messages arrived on /r1/command/heading"),
        (nth(GO, 17, lambda go: [*other_command(go), go]), "it announced|two messages arrived on"),
        (nth(GO, 17, double), "tick 18: the collective intelligence or node announced tick 17"),
    ],
)
def test_what_goes_wrong_on_the_way_to_the_simulation_ends_both_sides(tamper, problem):
    with (
        sides(CODE, tamper) as (simulation, lockstep, _),
        served(simulation) as ended,
        pytest.raises(TransportError, match=f"^run 1, tick .*(?:{problem})"),
    ):
        BusEngine(CODE, 1, lockstep).evaluate(specification(CODE, 1))

    assert len(ended) == 1


def test_every_command_is_sent_before_tick_0_and_later_only_changes():
    sent = {}

    def tamper(message):
        if message[0] == GO:
            sent["go"] = sent.get("go", 0) + 1
        elif "/command/" in message[0] and sent.get("go", 0) == 0:
            sent.setdefault("before tick 0", []).append(message[0])
        elif "/command/" in message[0]:
            sent["later"] = sent.get("later", 0) + 1
        return [message]

    flown(tamper)

    n_robots, n_sensors = len(CODE.mission.robots), len(CODE.mission.sensors)
    n_channels = 2 * n_robots + n_sensors
    assert len(set(sent["before tick 0"])) == len(sent["before tick 0"]) == n_channels
    assert sent["later"] < n_channels * sent["go"] / 2


@pytest.mark.parametrize(("late", "announced"), [(SPEED, TICK), ("/command/", GO)])
def test_what_arrives_after_its_announcement_is_waited_for(late, announced):
    held = []

    def tamper(message):
        if message[0] == announced:
            passed, held[:] = [message, *held], []
            return passed
        if late in message[0]:
            held.append(message)
            return []
        return [message]

    faults = specification(CODE, 1)

    assert flown(tamper, faults) == flown_in_process(faults)


def test_every_session_numbers_its_runs_from_a_random_number_on():
    sessions = []
    for _ in range(2):
        runs = set()

        def note(message, runs=runs):
            if message[0] in {GO, TICK}:
                runs.add(message[1]["data"][0])
            return [message]

        with sides(CODE, note) as (_, lockstep, _):
            for _ in range(2):
                BusEngine(CODE, 1, lockstep).evaluate(())
        sessions.append(sorted(runs))

    (first, second), (other, _) = sessions
    assert (first % 1_000_000, second) == (1, first + 1)
    assert abs(other - first) > 1
    assert second < 2**53


def test_a_lost_reset_is_repeated():
    assert flown(nth("/mission/setup", 0, lose)) == flown_in_process()


def test_a_reset_that_came_before_its_setup_is_repeated_at_once(monkeypatch):
    slept = []
    monkeypatch.setattr(bus_lockstep, "sleep", slept.append)
    with sides(CODE, nth("/mission/setup", 1, lose)) as (_, lockstep, _):
        engine = BusEngine(CODE, 1, lockstep)

        assert [engine.evaluate(()) for _ in range(2)] == 2 * [flown_in_process()]
    assert slept == []


def every_setup(change):
    """Return a tamper of what the CI says of every run."""
    tamper = numbers(change)
    return lambda message: tamper(message) if message[0] == "/mission/setup" else [message]


@pytest.mark.parametrize(
    ("change", "named"),
    [
        (lambda run, seed, _: [run, seed, 1], "semantics 1; run both"),
        (lambda run, seed, _: [run, seed, 99], "semantics 99; run both"),
    ],
)
def test_sides_of_different_semantics_refuse_each_other_at_once(change, named):
    patience = Patience(tick=0.5, handshake=600.0)
    said = rf"semantics {SEMANTICS} is the version of .*; /mission/setup requests {named}"
    with sides(CODE, every_setup(change), patience) as (simulation, lockstep, _):
        with pytest.raises(ProtocolError, match=f"run 1, before tick 0: the .* refuses .*{said}"):
            BusEngine(CODE, 1, lockstep).evaluate(())
        with pytest.raises(ProtocolError, match=said):
            simulation.serve()


def test_a_simulation_that_refused_serves_who_comes_next_with_its_own_semantics():
    with sides(CODE, nth("/mission/setup", 0, numbers(lambda *found: [*found[:2], 99]))) as (
        _,
        lockstep,
        _,
    ):
        engine = BusEngine(CODE, 1, lockstep)
        with pytest.raises(ProtocolError, match="requests semantics 99"):
            engine.evaluate(())

        assert engine.evaluate(()) == flown_in_process()


def test_a_simulation_that_does_not_understand_the_setup_is_not_waited_for():
    patience = Patience(tick=2.0, handshake=600.0)
    with (
        sides(CODE, every_setup(lambda *found: [*found, 1]), patience) as (simulation, lockstep, _),
        served(simulation),
        pytest.raises(
            ProtocolError,
            match=r"the simulation could not be set up: .*\[\d+, 1, 3, 1\]; expected 3 integers",
        ),
    ):
        BusEngine(CODE, 1, lockstep).evaluate(())


def test_a_simulation_that_never_answers_is_told_before_tick_0():
    with pytest.raises(TransportTimeout, match=r"run 1, before tick 0: no simulation was ready"):
        flown(
            lambda m: [] if m[0] == "/mission/setup" else [m],
            patience=Patience(tick=1.0, handshake=0.5),
        )


def test_a_lost_connection_ends_the_run_at_its_tick():
    def observe(world, belief, verdicts):
        if world.mission.tick == 23:
            transport.cut()

    with (
        sides(CODE) as (_, lockstep, transport),
        pytest.raises(TransportClosed, match="run 1, tick 23: cut"),
    ):
        BusEngine(CODE, 1, lockstep).evaluate((), observer=observe)


def test_an_error_in_a_region_ends_its_run_only():
    def check(view, violated):
        CODE.functions.check(view, violated)
        violated[0] = 1 // (30 - view.mission.tick) > 9

    broken = replace(CODE, functions=CODE.functions._replace(check=check))
    with sides(CODE) as (simulation, lockstep, _):
        with pytest.raises(EvaluationError, match="stopped at tick 30: ZeroDivisionError"):
            BusEngine(broken, 1, lockstep).evaluate(())
        outcome = BusEngine(CODE, 1, lockstep).evaluate(())

    assert simulation.where() == "no run"
    assert outcome == ReferenceEngine(CODE, 1).evaluate(())


def test_a_side_that_is_silent_in_mid_run_ends_its_run_and_the_next_is_served():
    patient = Patience(tick=5.0)  # it would tell the simulation to stop
    said = []
    with (
        sides(CODE, nth(GO, 17, lose), HASTY, patient, tell=said.append) as (simulation, ci, _),
        served(simulation) as ended,
    ):
        engine = BusEngine(CODE, 1, ci)
        problem = "run 1, tick 17: the collective intelligence or node was silent for 0.5 s"
        with pytest.raises(TransportError, match=f"the simulation failed: {problem}"):
            engine.evaluate(())
        outcome = engine.evaluate(())
        simulation.stop()

    assert outcome == flown_in_process()
    assert (ended, [problem in line for line in said]) == ([], [True])
    assert said[0].endswith("; this run is over, the simulation waits for the next")


@pytest.mark.parametrize(
    ("topic", "problem"),
    [
        (SPEED, r"none on [^;]*/r2/speed.*: a message was lost, or the server may have refused"),
        (TICK, "silent for 0.5 s; .*; nothing arrived on the topic that ends a tick, the server"),
        (GO, "silent for 0.5 s; .*; nothing arrived on /clock, /r1/energy, .*, the server may"),
    ],
)
def test_silence_before_the_first_tick_may_be_a_refused_type(topic, problem):
    with pytest.raises(TransportError, match=f"run 1, tick 0: .*{problem}.*: see its log"):
        flown(nth(topic, 0, lose), patience=HASTY if "silent" in problem else PATIENCE)


def test_silence_in_a_later_tick_is_no_refused_type():
    with pytest.raises(TransportError, match=r"tick 17: .*: a message was lost$"):
        flown(nth(SPEED, 17, lose))


def test_a_simulation_waits_for_the_first_tick_while_a_node_gets_ready():
    class Slow(Mind):
        def begin(self, flight, run, seed):
            sleep(0.8)

    with (
        sides(CODE, patience=HASTY, mind=Slow()) as (simulation, lockstep, _),
        served(simulation),
    ):
        outcome = BusEngine(CODE, 1, lockstep).evaluate(())
        simulation.stop()

    assert outcome == flown_in_process()


def test_an_idle_simulation_waits_for_ever():
    patience = Patience(tick=0.2, handshake=5.0)
    with sides(CODE, patience=patience) as (simulation, _, _):
        thread = Thread(target=simulation.serve)
        thread.start()
        thread.join(0.5)
        is_waiting = thread.is_alive()
        simulation.stop()
        thread.join()

    assert is_waiting
