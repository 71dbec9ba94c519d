"""Evaluates fault specifications with plain Python objects and the in-process bus.

Any Python is allowed in a region, a debugger works, and the messages of every tick pass
through the generated interface.

References
----------
Source paper, section III-G and Figure 4.
"""

import hashlib
import traceback
from pathlib import Path

from mrsfi_runtime.errors import EvaluationError, MrsfiError
from mrsfi_runtime.hosting.ci_host import CiHost
from mrsfi_runtime.hosting.lockstep import Observer, Violations, fly
from mrsfi_runtime.kernel.injections import Plan, plan
from mrsfi_runtime.kernel.state import State
from mrsfi_runtime.mission import MissionCode
from mrsfi_runtime.model.faults import FaultPool, Specification
from mrsfi_runtime.model.outcome import Outcome
from mrsfi_runtime.model.targets import require_no_overlap
from mrsfi_runtime.record.trace import state_bytes
from mrsfi_runtime.transport.local_bus import LocalBus


class ReferenceEngine:
    """Flies the mission once per fault specification.

    Parameters
    ----------
    code
        Generated code of the mission.
    seed
        Mission seed: two specifications of one engine meet the same weather.
    """

    def __init__(self, code: MissionCode, seed: int) -> None:
        self.code = code
        self.seed = seed
        self._bus = LocalBus()
        self._simulation = code.simulation(self._bus, code.mission)
        self._interface = code.interface(self._bus)

    def evaluate(
        self,
        specification: Specification,
        *,
        pool: FaultPool | None = None,
        observer: Observer | None = None,
    ) -> Outcome:
        """Fly the mission under a fault specification.

        Parameters
        ----------
        specification
            Timed faults; an empty one flies without faults.
        pool
            Where its faults come from; the mission's own pool if left out.
        observer
            Sees every tick.

        Raises
        ------
        SpecificationError
            If a fault is unknown, or conflicting faults overlap.
        EvaluationError
            If the code of a region fails.
        """
        code = self.code
        pool = code.pool if pool is None else pool
        require_no_overlap(code.mission, pool, specification)
        laid_out = plan(code.mission, pool, specification)
        self._simulation.reset(self.seed)
        ci = CiHost(code.mission, self._interface, code.checks, code.reactions, laid_out, self.seed)
        try:
            violations = fly(self._simulation, ci, code.checks, code.mission.duration, observer)
        except MrsfiError:
            raise
        except Exception as error:
            tick = self._simulation.world.mission.tick
            message = (
                f"{_place(error, code.directory)}mission '{code.mission.name}' failed at tick "
                f"{tick}: {type(error).__name__}: {error}; correct the region"
            )
            raise EvaluationError(message) from error
        return _outcome(violations, self._simulation.world, ci.belief, laid_out)


def _place(error: Exception, directory: Path) -> str:
    """Return file and line of the generated code in which an error arose, for a message."""
    frames = traceback.extract_tb(error.__traceback__)
    for frame in reversed(frames):
        path = Path(frame.filename)
        if path.parent == directory.absolute():
            return f"{directory / path.name}:{frame.lineno}: "
    return ""


def _outcome(violations: Violations, world: State, belief: State, laid_out: Plan) -> Outcome:
    counts = (
        tuple(violations.believed),
        tuple(violations.true),
        tuple(violations.phantom),
        tuple(violations.masked),
        tuple(goal.count for goal in world.goals),
        tuple(tally.applied for tally in laid_out.tallies),
        tuple(tally.changed for tally in laid_out.tallies),
    )
    sha = hashlib.sha256(repr(counts).encode())
    sha.update(state_bytes(world))
    sha.update(state_bytes(belief))
    return Outcome(*counts, digest=sha.hexdigest())
