"""The lock-step of two processes over a bus: the side of the CI, and that of the simulation.

A ``BusLockstep`` flies and judges runs for the collective intelligence (CI), with any
simulation behind the topics. A ``SimulationHost`` serves a generated simulation, run after run.
Each side takes its step when the last message of the other side has arrived, in the thread of the
transport's callbacks. A ``Completion`` passes progress and errors of a run to the main thread,
which checks time-outs.

Invariant: each run has a number, and messages of other runs are ignored. A side that
cannot continue sends the other side the reason.

Begin with ``BusLockstep.fly`` and ``_proceed``, then ``SimulationHost._fly``.

References
----------
Source paper, section III-F.
"""

import secrets
from collections.abc import Callable
from concurrent.futures import Future, InvalidStateError, wait
from contextlib import suppress
from functools import partial
from time import monotonic, sleep
from typing import Any

from mrsfi_runtime.cosimulation.bus_topics import (
    CLOCK,
    FAILURE,
    GO,
    REFUSAL,
    RESET,
    RUNS_OF_A_SESSION,
    SETUP,
    STOP,
    TICK,
    CountedTopics,
    Go,
    Patience,
    Setup,
    Tick,
    numbers,
)
from mrsfi_runtime.cosimulation.lockstep import (
    Flight,
    Heard,
    Mind,
    SimInterface,
    Simulation,
    take_true_values,
)
from mrsfi_runtime.cosimulation.programs import KeptProcess
from mrsfi_runtime.errors import (
    MrsfiError,
    ProtocolError,
    TransportClosed,
    TransportError,
    TransportTimeout,
    counted,
)
from mrsfi_runtime.kernel.commands import reports_position
from mrsfi_runtime.kernel.flight import initial_state
from mrsfi_runtime.model.fault_types import SEMANTICS
from mrsfi_runtime.model.mission import Mission
from mrsfi_runtime.transport.topics import (
    SEE_LOG,
    Payload,
    Reply,
    Service,
    Topic,
    Transport,
    seconds_of,
    time_of,
)


class Completion(Future[Any]):
    """Work of one thread for which another waits; it advances by steps, and ends once."""

    _n_steps = 0

    def advance(self) -> None:
        """Note a step."""
        self._n_steps += 1

    def end(self, result: object = None) -> None:
        """Note the end, and the result."""
        with suppress(InvalidStateError):
            self.set_result(result)

    def fail(self, error: Exception) -> None:
        """Note an error."""
        with suppress(InvalidStateError):
            self.set_exception(error)

    def wait(self, overdue: Callable[[float], MrsfiError | None]) -> Any:
        """Wait for the end; return the result, or raise the error.

        ``overdue`` gets the seconds since the last step; an error that it returns is raised.
        """
        n_steps, since = self._n_steps, monotonic()
        while not wait([self], 0.1).done:
            if n_steps != self._n_steps:
                n_steps, since = self._n_steps, monotonic()
                continue
            error = overdue(monotonic() - since)
            if error is not None:
                raise error
        return self.result()


class BusLockstep:
    """Flies runs over a transport, one after the other; ``truth`` are topics in model order.

    The ``mind`` answers received messages; by default, the generated reactions do. ``advertise``
    returns a function that publishes a command and counts it.

    A ``process`` of the simulation is started before the first flight, or for each. After an error,
    ``is_to_blame`` says whether it may have caused that, and has flown before. More late ticks than
    ``most_late`` in a flight are a ``TransportError``; ``n_late`` are those of the last flight.
    """

    def __init__(
        self,
        transport: Transport,
        mission: Mission,
        interface: type[SimInterface],
        truth: tuple[Topic, ...],
        patience: Patience,
        mind: Mind | None = None,
        process: KeptProcess | None = None,
        most_late: int = 0,
    ) -> None:
        self._transport = transport
        self._process = process
        self._most_late = most_late
        self._has_flown = self.is_to_blame = False
        self.n_late = 0
        self._mind = mind or Mind()
        self._mission = mission
        self._patience = patience
        self._completion = Completion()
        self._topics = CountedTopics(transport, "simulation", self._proceed)
        self._truth = tuple(Heard(self._topics, topic) for topic in truth)
        self._clock = Heard(self._topics, CLOCK)
        self._refusal: ProtocolError | None = None
        # a run's number fits into a double, as some clients keep numbers
        self._session = secrets.randbelow(10**9) * RUNS_OF_A_SESSION
        self._n_runs = 0
        self._flight: Flight | None = None
        self._is_thinking = False
        self.advertise = self._topics.advertise
        self._setup = transport.advertise(SETUP)
        self._go = transport.advertise(GO)
        self.interface = interface(self._topics)
        transport.subscribe(TICK, self._on_tick)
        transport.subscribe(FAILURE, self._on_failure)
        transport.watch(self.fail)

    @property
    def tick(self) -> int:
        """Return the tick that the run has reached."""
        return self._topics.tick

    def fly(self, flight: Flight, seed: int) -> None:
        """Fly a run to its end; its true state follows the simulation's ``/truth`` topics.

        Errors of the bus are raised as a ``TransportError`` that names run and tick.
        """
        self.n_late = 0
        try:
            self._prepare(seed)
            self._has_flown = True
            self._mind.begin(flight, self._run, seed)
            self._completion = Completion()
            for topic in (*self._truth, self._clock):
                topic.forget()
            self._is_thinking = False
            self._flight = flight
            self._topics.open()
            world = initial_state(self._mission, seed)
            flight.begin(world, sends_all=True)  # the simulation may be external
            self._mind.soon(partial(self._send_go, 0))
            self._completion.wait(self._overdue)
            self._topics.close()
            self._mind.end()
            self._call(STOP, self._patience.tick)
            self._flight = None
        except TransportError as error:
            self.is_to_blame = self._process is not None and self._has_flown
            where = "before tick 0" if self._flight is None else f"tick {self.tick}"
            raise type(error)(f"run {self._n_runs}, {where}: {error}") from error
        finally:
            self._topics.close()
            if self._flight is not None:
                self._flight = None
                with suppress(TransportError):  # already raised
                    self._transport.call(STOP, {}, lambda _reply: None)

    def fail(self, error: Exception) -> None:
        """End the run with an error."""
        self._topics.close()  # it stays at the tick at which it failed
        self._completion.fail(error)

    @property
    def _run(self) -> int:
        return self._session + self._n_runs

    def _prepare(self, seed: int) -> None:
        """Reset the simulation until it answers for this run; start it first if it does not run.

        Each request waits for its answer, because a reset may be slow.
        """
        self._n_runs += 1
        self._refusal = None
        if self._process is not None and self._process.is_due:
            self._process.start(seed)
        deadline = monotonic() + self._patience.handshake
        is_overtaken = False
        while True:
            self._setup({"data": [*Setup(self._run, seed, SEMANTICS)]})
            reply = self._call(RESET, self._patience.handshake)
            answer = reply.problem or str(reply.values.get("message"))
            if answer == f"run {self._run}":
                return
            refusal = _refused(answer) if answer.startswith(REFUSAL) else self._refusal
            if refusal is not None:
                raise refusal
            if answer.startswith("run ") and not is_overtaken:
                is_overtaken = True  # reset came before setup, as on a server of ROS 2
                continue
            if (ended := self._ending()) is not None:
                raise ended
            if monotonic() > deadline:
                raise TransportTimeout(
                    f"no simulation was ready within {self._patience.handshake:g} s: {answer}; "
                    "start one (mrsfi simulate MISSION --engine rosbridge --side simulation "
                    f"--url URL), or increase --timeout; if one runs, {SEE_LOG}"
                )
            sleep(0.1)

    def _call(self, service: Service, timeout: float) -> Reply:
        """Call a service of the simulation and wait for its reply, or for its refusal."""
        completion = Completion()
        self._completion = completion
        self._transport.call(service, {}, completion.end)
        late = TransportTimeout(
            f"the simulation did not answer {service.name} within {timeout:g} s; check that it "
            "still runs, or increase --timeout"
        )
        reply: Reply = completion.wait(
            lambda silence: self._ending() or self._refusal or (late if silence > timeout else None)
        )
        return reply

    def _ending(self) -> TransportClosed | None:
        return None if self._process is None else self._process.ended()

    def _overdue(self, silence: float) -> MrsfiError | None:
        if (ended := self._ending()) is not None:
            return ended
        error = self._mind.overdue(silence if self._is_thinking else 0.0)
        if error is not None or self._is_thinking:
            return error
        return self._topics.overdue(silence, self._patience.tick)

    def _on_failure(self, payload: Payload) -> None:
        reason = str(payload.get("data"))
        if self._topics.is_open:
            raise TransportError(f"the simulation failed: {reason}")
        if self._flight is None and str(self._run) in reason:  # its reset failed
            self._refusal = _refused(reason)

    def _on_tick(self, payload: Payload) -> None:
        reported = numbers(TICK, payload, Tick)
        if not self._topics.is_open or reported.run != self._run:
            return
        self._completion.advance()
        self._count_late(reported)
        is_complete = self._topics.announced(reported.tick, reported.n_messages)
        if reported.n_commands != self._topics.n_sent:
            raise ProtocolError(
                f"the simulation flew after {reported.n_commands} commands; "
                f"{self._topics.n_sent} were sent since the reset: it must count commands, and "
                "wait for the number that /mission/go announces (docs/bus.md)"
            )
        if is_complete:
            self._proceed()

    def _count_late(self, reported: Tick) -> None:
        self.n_late += reported.n_late > 0
        if self.n_late > self._most_late:
            raise TransportError(
                f"commands came too late in {counted(self.n_late, 'ticks')}; expected at most "
                f"{self._most_late} of {self._mission.duration}; let the simulator run slower, or "
                "increase --late"
            )

    def _proceed(self) -> None:
        flight, tick = self._flight, self._topics.tick
        if flight is None:
            return
        self._take_truth(flight)
        is_last = tick + 1 == self._mission.duration
        self._topics.is_muted = is_last  # commands have no effect after the last motion
        self._is_thinking = True
        flight.hear(tick)
        if self._mind.answer(flight, tick, self._reply):
            self._reply()

    def _reply(self) -> None:
        flight, tick = self._flight, self._topics.tick
        if flight is None:
            return
        flight.reply(tick)
        self._is_thinking = False
        if not self._topics.is_open:
            return
        if tick + 1 == self._mission.duration:
            self._completion.end()
            return
        self._topics.turn()
        self._send_go(tick + 1)
        self._completion.advance()

    def _take_truth(self, flight: Flight) -> None:
        """Take the true state of this tick, and check that all due messages have arrived."""
        world, tick = flight.world, self._topics.tick
        for index, topic in enumerate(self._truth):
            take_true_values(world, index, topic)
        world.mission.tick = tick
        secs = seconds_of(self._clock.take()["clock"])
        if secs != tick:
            raise ProtocolError(f"{CLOCK.name} carried {secs} s; expected {tick} s, one per tick")
        for index, robot in enumerate(self.interface.robots):
            robot.require_position(is_due=reports_position(world, index))
        for sensor, state in zip(self.interface.sensors, world.sensors, strict=True):
            sensor.require_active(state.active)

    def _send_go(self, tick: int) -> None:
        self._go({"data": [self._run, tick, self._topics.announce()]})


def _refused(reason: str) -> ProtocolError:
    refuses = f"refuses {SETUP.name} of semantics {SEMANTICS}"
    what = refuses if reason.startswith(REFUSAL) else "could not be set up"
    return ProtocolError(f"the simulation {what}: {reason}")


class SimulationHost:
    """Serves one generated simulation, run after run.

    ``patience`` limits how long the other side may be silent during a run, and before its first
    tick; a run that exceeds it is over, and ``tell`` receives that.
    """

    def __init__(
        self,
        transport: Transport,
        simulation: type[Simulation],
        mission: Mission,
        patience: Patience,
        tell: Callable[[str], None] = lambda _: None,
    ) -> None:
        self._patience = patience
        self._tell = tell
        self._ros = transport.ros
        self._completion = Completion()
        self._topics = CountedTopics(transport, "collective intelligence or node", self._fly)
        self._run = 0
        self._failed_at: str | None = None
        self._setup: Setup | None = None
        self._refusal: ProtocolError | None = None
        self._simulation = simulation(self._topics, mission)
        self._clock = self._topics.advertise(CLOCK)
        self._tick = transport.advertise(TICK)
        self._failure = transport.advertise(FAILURE)
        transport.watch(self._fail)
        transport.subscribe(SETUP, self._on_setup)
        transport.subscribe(GO, self._on_go)
        transport.provide(RESET, self._on_reset)
        transport.provide(STOP, self._on_stop)

    def serve(self) -> None:
        """Serve runs until ``stop`` is called, or until an error, whose reason the CI receives.

        Lost messages, a lost connection, and a CI of other semantics are a ``TransportError``.
        Errors of the simulation's own code are raised as is.
        """
        try:
            self._completion.wait(self._overdue)
        except Exception as error:
            with suppress(TransportError):
                self._failure({"data": f"{self.where()}: {error}"})
            raise

    def stop(self) -> None:
        """Let ``serve`` return; may be called by any thread."""
        self._completion.end()

    def where(self) -> str:
        """Return run and tick, for messages."""
        if self._failed_at is not None:
            return self._failed_at
        if not self._topics.is_open:
            return "no run"
        return f"run {self._run % RUNS_OF_A_SESSION}, tick {self._topics.tick}"

    def _fail(self, error: Exception) -> None:
        self._failed_at = self.where()
        self._topics.close()  # the run stays at the tick at which it failed
        self._completion.fail(error)

    def _abandon(self, error: TransportTimeout) -> None:
        """End a run, and wait for the next one."""
        reason = f"{self.where()}: {error}"
        self._topics.close()
        self._failure({"data": reason})
        self._tell(f"{reason}; this run is over, the simulation waits for the next")

    def _overdue(self, silence: float) -> MrsfiError | None:
        if self._refusal is None:
            patience = self._patience.tick if self._topics.tick else self._patience.handshake
            error = self._topics.overdue(silence, patience)
            if isinstance(error, TransportTimeout):
                self._abandon(error)
                return None
            return error
        return self._refusal if silence > self._patience.tick else None

    def _on_setup(self, payload: Payload) -> None:
        self._setup = numbers(SETUP, payload, Setup)

    def _on_reset(self, _request: Payload) -> Payload:
        if self._setup is None:
            return {"success": False, "message": f"no message on {SETUP.name} has arrived yet"}
        self._run, seed, semantics = self._setup
        self._refusal = None
        if semantics != SEMANTICS:
            self._refusal = ProtocolError(
                f"{REFUSAL} {SEMANTICS} is the version of this simulation; {SETUP.name} requests "
                f"semantics {semantics}; run both sides with the same version of mrsfi"
            )
            self._topics.close()
            self._completion.advance()
            return {"success": False, "message": str(self._refusal)}
        self._simulation.reset(seed)
        self._topics.open()
        self._completion.advance()
        return {"success": True, "message": f"run {self._run}"}

    def _on_stop(self, _request: Payload) -> Payload:
        self._topics.close()
        return {"success": True, "message": ""}

    def _on_go(self, payload: Payload) -> None:
        go = numbers(GO, payload, Go)
        if not self._topics.is_open or go.run != self._run:
            return
        self._completion.advance()
        if self._topics.announced(go.tick, go.n_commands):
            self._fly()

    def _fly(self) -> None:
        tick = self._topics.tick
        self._topics.turn()
        self._simulation.step(tick)
        self._simulation.publish_truth()
        self._clock({"clock": time_of(tick, self._ros)})
        self._tick({"data": [self._run, tick, self._topics.announce(), self._topics.n_before]})
        self._completion.advance()
