"""The simulation's side of a mission over a bus: flies a tick whenever it is told to.

References
----------
Source paper, section III-F.
"""

from mrsfi_runtime.cosimulation.counted_topics import CountedTopics
from mrsfi_runtime.cosimulation.lockstep_topics import (
    CLOCK,
    FAILURE,
    GO,
    REFUSAL,
    RESET,
    RUNS_OF_A_SESSION,
    SETUP,
    STOP,
    TICK,
    Go,
    Setup,
    numbers,
)
from mrsfi_runtime.cosimulation.sides import Simulation
from mrsfi_runtime.cosimulation.waiting import Completion, Patience
from mrsfi_runtime.errors import MrsfiError, ProtocolError
from mrsfi_runtime.model.fault_types import SEMANTICS
from mrsfi_runtime.model.mission import Mission
from mrsfi_runtime.transport.topics import Payload, Transport, time_of


class SimulationHost:
    """Serves one generated simulation, run after run.

    ``patience`` says how long the CI may be silent in mid-run, and before, while its node begins.
    """

    def __init__(
        self,
        transport: Transport,
        simulation: type[Simulation],
        mission: Mission,
        patience: Patience,
    ) -> None:
        self._patience = patience
        self._ros = transport.ros
        self._completion = Completion()
        self._topics = CountedTopics(transport, "collective intelligence", self._fly)
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
        """Serve runs until ``stop`` is called.

        Lost messages, a lost connection, or a CI that is silent in mid-run or of other semantics,
        are a ``TransportError``; what the simulation's own code raises goes through.
        """
        self._completion.wait(self._overdue)

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

    def tell_failure(self, error: Exception) -> None:
        """Tell the CI why the simulation cannot go on."""
        self._failure({"data": f"{self.where()}: {error}"})

    def _fail(self, error: Exception) -> None:
        self._failed_at = self.where()
        self._topics.close()  # the run stays at the tick at which it failed
        self._completion.fail(error)

    def _overdue(self, silence: float) -> MrsfiError | None:
        if self._refusal is None:
            patience = self._patience.tick if self._topics.tick else self._patience.handshake
            return self._topics.overdue(silence, patience)
        return self._refusal if silence > self._patience.tick else None

    def _on_setup(self, payload: Payload) -> None:
        self._setup = numbers(SETUP, payload, Setup)

    def _on_reset(self, _request: Payload) -> Payload:
        if self._setup is None:
            return {"success": False, "message": f"no message on {SETUP.name} came yet"}
        self._run, seed, semantics = self._setup
        self._refusal = None if semantics == SEMANTICS else _refused(semantics)
        if self._refusal is not None:
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


def _refused(semantics: int) -> ProtocolError:
    """Return what a CI of other rules is answered."""
    return ProtocolError(
        f"{REFUSAL} {SEMANTICS} is what this simulation flies; {SETUP.name} asked for semantics "
        f"{semantics}; run both sides with one mrsfi"
    )
