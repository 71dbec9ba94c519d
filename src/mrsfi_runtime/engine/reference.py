"""Evaluates fault specifications with plain Python objects and the in-process bus.

The messages of every tick pass through the generated interface.

References
----------
Source paper, section III-G and Figure 4.
"""

from mrsfi_runtime.cosimulation.lockstep import Flight
from mrsfi_runtime.engine.flights import PlainEngine
from mrsfi_runtime.generated_code import MissionCode
from mrsfi_runtime.transport.topics import LocalBus


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
