"""A flight with what the user wants written of it: log, trace, bag and page; and printed."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from typing import IO, Any, TypeAlias

from mrsfi.versions import installed_version
from mrsfi_runtime.analysis.campaign_tables import (
    fault_table,
    faults_as_json,
    goal_table,
    goals_as_json,
)
from mrsfi_runtime.cli.console import print_json, tell
from mrsfi_runtime.cli.options import FlightFiles
from mrsfi_runtime.cli.progress import flight_progress
from mrsfi_runtime.cli.terminal import print_table
from mrsfi_runtime.cosimulation.lockstep import Observer
from mrsfi_runtime.engine.flights import Engine, PlainEngine
from mrsfi_runtime.files import whole_file, written_file
from mrsfi_runtime.kernel.initial import initial_state
from mrsfi_runtime.kernel.injections import FaultTally
from mrsfi_runtime.model.faults import FaultPool, Specification
from mrsfi_runtime.model.gate import Gate
from mrsfi_runtime.model.mission import Mission
from mrsfi_runtime.model.outcome import Outcome
from mrsfi_runtime.record.named_faults import NamedFault, named_faults
from mrsfi_runtime.record.observers import Events, SimulationLog, TraceTable


@dataclass(frozen=True, slots=True)
class Subject:
    """What a page says a flight is, what flies it again, and its specification as XMI."""

    title: str
    command: Sequence[str]
    xmi: str = ""


def fly_recorded(
    engine: Engine,
    specification: Specification,
    pool: FaultPool,
    files: FlightFiles,
    subject: Subject,
) -> Outcome:
    """Fly once under faults of a pool, and write the wanted files."""
    specification = Gate(engine.code.mission, pool).admitted(specification)
    faults = named_faults(engine.code.mission, pool, specification)
    tallies = [FaultTally() for _ in specification]
    with _recorder(engine, files, faults, tallies, subject) as (observer, finish):
        outcome = engine.evaluate(specification, pool=pool, observer=observer, tallies=tallies)
        for write in finish:
            write(outcome)
    for path in files.wanted:
        tell(f"written    {path}")
    return outcome


def print_flight(
    mission: Mission,
    pool: FaultPool,
    specification: Specification,
    outcome: Outcome,
    title: str,
    head: Mapping[str, object] | None,
) -> None:
    """Print what happened to each goal, under which faults; for a script, where it has a head."""
    faults = named_faults(mission, pool, specification)
    if head is not None:
        goals = goals_as_json(mission, outcome)
        print_json({**head, "goals": goals, "faults": faults_as_json(faults, outcome)})
        return
    print_table(goal_table(title, mission, outcome))
    if faults:
        print_table(fault_table("Faults", faults, outcome))


_Finish: TypeAlias = Callable[[Outcome], None]
"""Writes what is written when the flight is over."""


@contextmanager
def _recorder(
    engine: Engine,
    files: FlightFiles,
    faults: Sequence[NamedFault],
    tallies: Sequence[FaultTally],
    subject: Subject,
) -> Iterator[tuple[Observer | None, Sequence[_Finish]]]:
    """Yield an observer for the wanted files, or ``None`` if none is wanted, and what ends them."""
    mission = engine.code.mission
    with ExitStack() as opened:
        observers: list[Observer] = []
        finish: list[_Finish] = []
        if isinstance(engine, PlainEngine):  # others take no time
            observers.append(flight_progress(mission.duration))
        observers += _texts(opened, files, mission, Events(mission, faults, tallies))
        if files.mcap is not None:
            from mrsfi_runtime.record.bag import Bag

            whole = opened.enter_context(whole_file(files.mcap))
            bag = Bag(mission, whole, faults, Events(mission, faults, tallies))
            observers.append(bag)
            finish.append(lambda _: bag.finish())
        for path, shown in ((files.html, _page), (files.gif, _animation)):
            if path is not None:
                whole = opened.enter_context(whole_file(path))
                observer, write = shown(engine, whole, faults, subject)
                observers.append(observer)
                finish.append(write)

        def observe(*tick: Any) -> None:
            for observer in observers:
                observer(*tick)

        yield observe if observers else None, finish


def _texts(
    opened: ExitStack, files: FlightFiles, mission: Mission, events: Events
) -> Iterator[Observer]:
    """Yield what writes the log and the trace, as far as they are wanted."""
    if files.log is not None:
        yield SimulationLog(mission, opened.enter_context(written_file(files.log)), events)
    if files.trace is not None:
        yield TraceTable(mission, opened.enter_context(written_file(files.trace)))


def _page(
    engine: Engine, stream: IO[bytes], faults: Sequence[NamedFault], subject: Subject
) -> tuple[Observer, _Finish]:
    """Return what records a flight for a page, and what writes the page; numpy comes with that."""
    from mrsfi_runtime.analysis.page.content import PageEntry, flight_page
    from mrsfi_runtime.analysis.page.document import document
    from mrsfi_runtime.engine.recording import Recorder

    mission = engine.code.mission
    recorder = Recorder(initial_state(mission, engine.seed))

    def write(outcome: Outcome) -> None:
        told = PageEntry(subject.title, "", faults, (), outcome, subject.command, subject.xmi)
        facts = {
            "mission": mission.name,
            "ticks": mission.duration,
            "mission seed": engine.seed,
            "mrsfi": installed_version("mrsfi"),
            "digest": outcome.digest,
        }
        page = flight_page(mission, told, recorder.recording(), facts.items())
        stream.write(document(page).encode())

    return recorder, write


def _animation(
    engine: Engine, stream: IO[bytes], faults: Sequence[NamedFault], subject: Subject
) -> tuple[Observer, _Finish]:
    """Return what records a flight for a picture, and what draws it; matplotlib comes with that."""
    from mrsfi_runtime.analysis.mission_plots import flight_gif
    from mrsfi_runtime.analysis.story import story_of
    from mrsfi_runtime.engine.recording import Recorder

    mission = engine.code.mission
    recorder = Recorder(initial_state(mission, engine.seed))

    def write(_: Outcome) -> None:
        story = story_of(subject.title, mission, faults, recorder.recording())
        stream.write(flight_gif(story))

    return recorder, write
