"""Fly one fault specification and write down what happened on the way."""

from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path

import click

from m2t.generate import fault_loader_text
from m2t.load import load_specification
from mrsfi_runtime.cli.console import tell, written_file
from mrsfi_runtime.cli.engines import F
from mrsfi_runtime.errors import UsageError
from mrsfi_runtime.hosting.lockstep import Observer
from mrsfi_runtime.kernel.state import State
from mrsfi_runtime.mission import pool_from_text
from mrsfi_runtime.model.faults import FaultPool
from mrsfi_runtime.model.mission import Mission
from mrsfi_runtime.record.observers import SimulationLog, TraceTable


def recording_options(command: F) -> F:
    """Give a command the options --log and --trace."""
    for name, text in (
        ("--trace", "Write belief and truth of every tick to FILE as CSV."),
        ("--log", "Write the simulation log to FILE: every robot each tick, and events."),
    ):
        kind = click.Path(path_type=Path, dir_okay=False)
        command = click.option(name, type=kind, metavar="FILE", help=text)(command)
    return command


def specification_pool(path: Path) -> FaultPool:
    """Return the faults of a written fault specification, with windows and values.

    Raises
    ------
    UsageError
        If there is no such file.
    ModelError
        If it cannot be used.
    """
    if not path.is_file():
        raise UsageError(f"{path}: no such file; expected a fault specification in XMI")
    return pool_from_text(fault_loader_text(load_specification(path)))


@contextmanager
def recorder(mission: Mission, log: Path | None, trace: Path | None) -> Iterator[Observer | None]:
    """Yield an observer that writes the wanted files, or ``None`` if none is wanted."""
    with ExitStack() as files:
        observers: list[Observer] = []
        if log is not None:
            observers.append(SimulationLog(mission, files.enter_context(written_file(log))))
        if trace is not None:
            observers.append(TraceTable(mission, files.enter_context(written_file(trace))))
        yield _all_of(observers) if observers else None
    for path in (log, trace):
        if path is not None:
            tell(f"written    {path}")


def _all_of(observers: Sequence[Observer]) -> Observer:
    def observe(
        world: State, belief: State, true: Sequence[bool], believed: Sequence[bool]
    ) -> None:
        for observer in observers:
            observer(world, belief, true, believed)

    return observe
