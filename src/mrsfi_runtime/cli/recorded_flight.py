"""A flight with what the user wants written of it: log and trace."""

from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

from mrsfi_runtime.cli.console import tell, written_file
from mrsfi_runtime.engine.flights import Engine
from mrsfi_runtime.hosting.lockstep import Observer
from mrsfi_runtime.kernel.injections import FaultTally
from mrsfi_runtime.model.faults import FaultPool, Specification
from mrsfi_runtime.model.mission import Mission
from mrsfi_runtime.model.outcome import Outcome
from mrsfi_runtime.model.targets import require_no_overlap
from mrsfi_runtime.record.named_faults import NamedFault, named_faults
from mrsfi_runtime.record.observers import SimulationLog, TraceTable


def fly_recorded(
    engine: Engine,
    specification: Specification,
    pool: FaultPool,
    log: Path | None,
    trace: Path | None,
) -> Outcome:
    """Fly once under faults of a pool, and write the wanted files."""
    require_no_overlap(engine.code.mission, pool, specification)
    faults = named_faults(engine.code.mission, pool, specification)
    tallies = [FaultTally() for _ in specification]
    with _recorder(engine.code.mission, log, trace, faults, tallies) as observer:
        outcome = engine.evaluate(specification, pool=pool, observer=observer, tallies=tallies)
    for path in (log, trace):
        if path is not None:
            tell(f"written    {path}")
    return outcome


@contextmanager
def _recorder(
    mission: Mission,
    log: Path | None,
    trace: Path | None,
    faults: Sequence[NamedFault],
    tallies: Sequence[FaultTally],
) -> Iterator[Observer | None]:
    """Yield an observer that writes the wanted files, or ``None`` if none is wanted."""
    with ExitStack() as files:
        observers: list[Observer] = []
        if log is not None:
            stream = files.enter_context(written_file(log))
            observers.append(SimulationLog(mission, stream, faults, tallies))
        if trace is not None:
            observers.append(TraceTable(mission, files.enter_context(written_file(trace))))

        def observe(*tick: Any) -> None:
            for observer in observers:
                observer(*tick)

        yield observe if observers else None
