"""A mission whose two sides meet over two ends of any transport, in this process."""

from mrsfi_runtime.cosimulation.bus_lockstep import BusLockstep, SimulationHost
from mrsfi_runtime.cosimulation.bus_topics import Patience
from mrsfi_runtime.cosimulation.lockstep import Flight
from mrsfi_runtime.engine.flights import PlainEngine
from mrsfi_runtime.generated_code import MissionCode
from mrsfi_runtime.transport.topics import Transport


class BusEngine(PlainEngine):
    """Flies on a lock-step that is there already, and does not close it."""

    def __init__(self, code: MissionCode, seed: int, lockstep: BusLockstep) -> None:
        super().__init__(code, seed)
        self._lockstep = lockstep
        self.interface = lockstep.interface

    def close(self) -> None:
        """Do nothing: the ends belong to others."""

    def _fly(self, flight: Flight, seed: int) -> None:
        self._lockstep.fly(flight, seed)


class TwoSides(BusEngine):
    """Flies with simulation and collective intelligence at an end each; closes neither."""

    def __init__(self, code: MissionCode, seed: int, first: Transport, second: Transport) -> None:
        patience = Patience()
        self._simulation = SimulationHost(second, code.simulation, code.mission, patience)
        lockstep = BusLockstep(first, code.mission, code.interface, code.truth, patience)
        super().__init__(code, seed, lockstep)
