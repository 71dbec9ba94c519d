"""What all engines that fly with plain Python objects share: plan, board, judge."""

import hashlib
import traceback
from collections.abc import Callable
from pathlib import Path
from types import TracebackType
from typing import Protocol, Self

from mrsfi_runtime.errors import EvaluationError, MrsfiError
from mrsfi_runtime.hosting.ci_host import CiHost
from mrsfi_runtime.hosting.lockstep import Boarding, Flight, Observer
from mrsfi_runtime.hosting.sides import SimInterface
from mrsfi_runtime.kernel.injections import Plan, plan
from mrsfi_runtime.kernel.state import State
from mrsfi_runtime.mission import MissionCode
from mrsfi_runtime.model.faults import FaultPool, Specification
from mrsfi_runtime.model.outcome import Outcome
from mrsfi_runtime.model.targets import require_no_overlap
from mrsfi_runtime.record.trace import state_bytes


class Engine(Protocol):
    """Evaluates fault specifications of one mission, all in the same weather.

    Used as a context manager, it closes itself.
    """

    code: MissionCode
    seed: int

    def __enter__(self) -> Self: ...

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        where: TracebackType | None,
    ) -> None: ...

    def evaluate(
        self,
        specification: Specification,
        *,
        pool: FaultPool | None = None,
        observer: Observer | None = None,
    ) -> Outcome:
        """Fly the mission under a fault specification."""

    def close(self) -> None:
        """Give up what the engine holds."""


def evaluate(
    engine: Engine,
    specification: Specification,
    pool: FaultPool | None,
    observer: Observer | None,
    fly: Callable[[Boarding], Flight],
) -> Outcome:
    """Fly the mission of an engine under a fault specification.

    Parameters
    ----------
    engine
        Knows code and seed.
    specification
        Timed faults; an empty one flies without faults.
    pool
        Where its faults come from; the mission's own pool if left out.
    observer
        Sees every tick.
    fly
        Gets what boards a flight, and returns the flight after its last tick.

    Raises
    ------
    SpecificationError
        If a fault is unknown, or conflicting faults overlap.
    EvaluationError
        If the code of a region fails.
    """
    code = engine.code
    pool = code.pool if pool is None else pool
    require_no_overlap(code.mission, pool, specification)
    laid_out = plan(code.mission, pool, specification)
    boarded: list[Flight] = []

    def board(interface: SimInterface, world: State) -> Flight:
        ci = CiHost(code.mission, interface, code.checks, code.reactions, laid_out, engine.seed)
        boarded.append(Flight(world, ci, code.checks, observer))
        return boarded[0]

    try:
        flight = fly(board)
    except MrsfiError:
        raise
    except Exception as error:
        tick = boarded[0].world.mission.tick if boarded else 0
        message = (
            f"{_place(error, code.directory)}mission '{code.mission.name}' failed at tick "
            f"{tick}: {type(error).__name__}: {error}; correct the region"
        )
        raise EvaluationError(message) from error
    return _outcome(flight, laid_out)


def _place(error: Exception, directory: Path) -> str:
    """Return file and line of the generated code in which an error arose, for a message."""
    frames = traceback.extract_tb(error.__traceback__)
    for frame in reversed(frames):
        path = Path(frame.filename)
        if path.parent == directory.absolute():
            return f"{directory / path.name}:{frame.lineno}: "
    return ""


def _outcome(flight: Flight, laid_out: Plan) -> Outcome:
    violations = flight.violations
    counts = (
        tuple(violations.believed),
        tuple(violations.true),
        tuple(violations.phantom),
        tuple(violations.masked),
        tuple(goal.count for goal in flight.world.goals),
        tuple(tally.applied for tally in laid_out.tallies),
        tuple(tally.changed for tally in laid_out.tallies),
    )
    sha = hashlib.sha256(repr(counts).encode())
    sha.update(state_bytes(flight.world))
    sha.update(state_bytes(flight.ci.belief))
    return Outcome(*counts, digest=sha.hexdigest())
