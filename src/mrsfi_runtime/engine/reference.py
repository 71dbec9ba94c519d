"""Evaluates fault specifications with plain Python objects and the in-process bus.

Any Python is allowed in a region, a debugger works, and the messages of every tick pass
through the generated interface.

References
----------
Source paper, section III-G and Figure 4.
"""

from collections.abc import Iterator, Sequence
from types import TracebackType
from typing import Self

from mrsfi_runtime.engine import flights
from mrsfi_runtime.engine.flights import Evaluated
from mrsfi_runtime.hosting.lockstep import Boarding, Flight, Observer, fly
from mrsfi_runtime.mission import MissionCode
from mrsfi_runtime.model.faults import FaultPool, Specification
from mrsfi_runtime.model.outcome import Outcome
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

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        where: TracebackType | None,
    ) -> None:
        self.close()

    def close(self) -> None:
        """Do nothing: the engine holds nothing but memory."""

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
        return flights.evaluate(self, specification, pool, observer, self._fly)

    def evaluate_many(self, specifications: Sequence[Specification]) -> Iterator[Evaluated]:
        """Evaluate specifications, and yield the results in the same order, as they come."""
        return (flights.attempt(self, specification) for specification in specifications)

    def _fly(self, board: Boarding) -> Flight:
        self._simulation.reset(self.seed)
        flight = board(self._interface, self._simulation.world)
        fly(self._simulation, flight, self.code.mission.duration)
        return flight
