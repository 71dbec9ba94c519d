"""The interface of engines, and the reference engine.

An ``Evaluator`` evaluates fault specifications. An ``Engine`` also flies single missions. First it
checks the specification for overlaps, unknown faults and effects without a region. Every engine
gives the same outcome and the same digest for the same specification and mission seed.

A ``PlainEngine`` flies on plain Python objects; its subclasses carry the messages of every tick
over a bus. ``ReferenceEngine`` uses the in-process bus and the generated interface.

References
----------
Source paper, section III-G and Figure 4.
"""

import hashlib
import traceback
from abc import ABC, abstractmethod
from collections.abc import Iterable, Iterator, Sequence
from typing import TYPE_CHECKING, NamedTuple, Self

from mrsfi_runtime.cosimulation.lockstep import Flight, Observer, SimInterface, guarded
from mrsfi_runtime.engine.compiled.regions import measured_goals
from mrsfi_runtime.errors import EvaluationError, SpecificationError, WorkerLost
from mrsfi_runtime.fence import fenced
from mrsfi_runtime.generated_code import MissionCode, failed
from mrsfi_runtime.kernel.flight import initial_state
from mrsfi_runtime.kernel.goal_tasks.common import NO_MARGIN
from mrsfi_runtime.kernel.injections import FaultTally, plan
from mrsfi_runtime.kernel.state import state_bytes
from mrsfi_runtime.model.fault_types import Mode
from mrsfi_runtime.model.faults import FaultPool, Gate, Specification
from mrsfi_runtime.model.mission import COUNTED, Evaluated, FailedFlight, Outcome
from mrsfi_runtime.transport.topics import LocalBus

if TYPE_CHECKING:
    from mrsfi_runtime.engine.recording import Recording


class Evaluator(ABC):
    """Evaluates fault specifications of one mission; as a context manager it closes itself."""

    n_workers = 1

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    @abstractmethod
    def evaluate_many(
        self, specifications: Sequence[Specification], seed: int | None = None
    ) -> Iterator[Evaluated]:
        """Evaluate with one mission seed, and yield the results in order, as they come."""

    def record_many(
        self, own: "Engine", specifications: Iterable[Specification]
    ) -> Iterator["Recording"]:
        """Record flights of the default mission seed, in order, on ``own`` if nowhere else."""
        return map(own.record, specifications)

    def close(self) -> None:  # noqa: B027 - most have nothing to release
        """Release its resources, if any; it may be called again."""


class Request(NamedTuple):
    """A flight for an engine: a specification without overlaps, and an observer."""

    specification: Specification
    seed: int
    pool: FaultPool
    observer: Observer | None
    tallies: list[FaultTally]


class Engine(Evaluator):
    """Flies the mission; ``seed`` is the mission seed of flights that name none."""

    def __init__(self, code: MissionCode, seed: int) -> None:
        self.code = code
        self.measured = measured_goals(code)
        self.seed = seed

    def evaluate(
        self,
        specification: Specification,
        seed: int | None = None,
        *,
        pool: FaultPool | None = None,
        observer: Observer | None = None,
        tallies: list[FaultTally] | None = None,
    ) -> Outcome:
        """Fly the mission under a fault specification, of the mission's pool or another.

        The observer is called at every tick, in any thread. Before the first tick, ``tallies``
        receives a tally for each timed fault, which counts while the fault acts: at each tick its
        ``first_changed`` is up to date; counts are complete when the flight has ended.
        """
        pool = self.code.pool if pool is None else pool
        require_effects(self.code.pool, pool)
        specification = Gate(self.code.mission, pool).admitted(specification)
        seed = self.seed if seed is None else seed
        tallies = [] if tallies is None else tallies
        return self._evaluate(Request(specification, seed, pool, observer, tallies))

    def record(self, specification: Specification, seed: int | None = None) -> "Recording":
        """Fly the mission under a specification of its pool, and return every tick."""
        specification = Gate(self.code.mission, self.code.pool).admitted(specification)
        return self._record(specification, self.seed if seed is None else seed)

    def attempt(
        self,
        specification: Specification,
        seed: int | None = None,
        observer: Observer | None = None,
    ) -> Evaluated:
        """Evaluate a specification; an error in a region is a result too."""
        try:
            return self.evaluate(specification, seed, observer=observer)
        except WorkerLost:
            raise
        except EvaluationError:
            return FailedFlight(traceback.format_exc())

    def evaluate_many(
        self, specifications: Sequence[Specification], seed: int | None = None
    ) -> Iterator[Evaluated]:
        """Evaluate specifications, and yield the results in the same order, as they come."""
        return (self.attempt(specification, seed) for specification in specifications)

    @abstractmethod
    def _evaluate(self, request: Request) -> Outcome:
        """Fly once."""

    def _record(self, specification: Specification, seed: int) -> "Recording":
        """Return every tick of a flight under a specification without overlaps."""
        from mrsfi_runtime.engine.recording import Recorder  # noqa: PLC0415 - brings numpy

        recorder = Recorder(initial_state(self.code.mission, seed))
        request = Request(specification, seed, self.code.pool, recorder, [])
        self._evaluate(request)
        return recorder.recording(request.tallies)


class PlainEngine(Engine):
    """Flies on plain Python objects: any Python is allowed in a region, and a debugger works."""

    interface: SimInterface
    """Receives the messages of the simulation, and sends it commands."""
    patience = 0.0
    """The most seconds to wait for the simulation in a tick."""

    @abstractmethod
    def _fly(self, flight: Flight, seed: int) -> None:
        """Fly from the first tick to the last."""

    def _evaluate(self, request: Request) -> Outcome:
        code, (specification, seed, pool, observer, tallies) = self.code, request
        laid_out = plan(code.mission, pool, specification)
        tallies[:] = laid_out.tallies
        own = {fault.kind.effect: fault.kind for fault in pool if fault.kind.effect >= 0}
        functions = code.functions
        if own:
            functions = functions._replace(apply=guarded(functions.apply, own))
        flight = Flight(functions, code.mission, seed, self.interface, laid_out, observer)

        def tick() -> int:
            return flight.world.mission.tick

        def located(error: BaseException) -> EvaluationError:
            return failed(error, code.directory, f"the mission stopped at tick {tick()}")

        with fenced(located, tick, self.patience):
            self._fly(flight, seed)
            counts = (
                *(getattr(flight.verdicts, name) for name in COUNTED),
                [goal.count for goal in flight.world.goals],
                [tally.applied for tally in laid_out.tallies],
                [tally.changed for tally in laid_out.tallies],
            )
            verdicts = flight.verdicts
            margins = zip(verdicts.margin, verdicts.nearest, self.measured, strict=True)
            detection = zip(verdicts.broken, verdicts.undetected, strict=True)
            states = state_bytes(flight.world), state_bytes(flight.belief)
            return digested(counts, margins, detection, *states)


def require_effects(generated: FaultPool, pool: FaultPool) -> None:
    """Refuse faults whose effects are regions that the code generated for a pool lacks."""
    if pool is generated:
        return
    regions = {fault.type for fault in generated}
    for fault in pool:
        if fault.kind.mode is Mode.OWN and fault.type not in regions:
            raise SpecificationError(
                f"fault '{fault.id}' has type {fault.type}, but fault_effects.py has no region for "
                "its effect, because the mission's pool has no fault of this type; add one to its "
                "faults.xmi and run `mrsfi generate`"
            )


def digested(
    counts: Sequence[Sequence[int]],
    margins: Iterable[tuple[float, int, bool]],
    detection: Iterable[tuple[int, int]],
    world: bytes | memoryview,
    belief: bytes | memoryview,
) -> Outcome:
    """Return an outcome; its digest covers counts and last states, not margins and detection.

    Each margin comes with whether its goal has one.
    """
    believed, true, phantom, masked, missed, samples, applied, changed = map(tuple, counts)
    listed = (believed, true, phantom, masked, missed, samples, applied, changed)
    sha = hashlib.sha256(repr(listed).encode())
    sha.update(world)
    sha.update(belief)
    closest = ((m, at) if has_one and m != NO_MARGIN else None for m, at, has_one in margins)
    return Outcome(*listed, sha.hexdigest(), tuple(closest), tuple(detection))


class ReferenceEngine(PlainEngine):
    """Flies the mission once per fault specification."""

    def __init__(self, code: MissionCode, seed: int) -> None:
        super().__init__(code, seed)
        bus = LocalBus()
        self._simulation = code.simulation(bus, code.mission)
        self.interface = code.interface(bus)

    def _fly(self, flight: Flight, seed: int) -> None:
        self._simulation.reset(seed)
        flight.begin(self._simulation.world)
        for tick in range(self.code.mission.duration):
            self._simulation.step(tick)
            flight.step(tick)
