"""Evaluates fault specifications with plain Python objects and the in-process bus.

The messages of every tick pass through the generated interface.

References
----------
Source paper, section III-G and Figure 4.
"""

from mrsfi_runtime.engine.flights import PlainEngine
from mrsfi_runtime.hosting.lockstep import Flight, FlightMaker, fly
from mrsfi_runtime.mission import MissionCode
from mrsfi_runtime.transport.local_bus import LocalBus


class ReferenceEngine(PlainEngine):
    """Flies the mission once per fault specification."""

    def __init__(self, code: MissionCode, seed: int) -> None:
        super().__init__(code, seed)
        bus = LocalBus()
        self._simulation = code.simulation(bus, code.mission)
        self._interface = code.interface(bus)

    def close(self) -> None:
        """Do nothing: the engine holds nothing but memory."""

    def _fly(self, make_flight: FlightMaker, seed: int) -> Flight:
        self._simulation.reset(seed)
        flight = make_flight(self._interface, self._simulation.world)
        fly(self._simulation, flight, self.code.mission.duration)
        return flight
