"""Fly once, write a log, trace, bag, page or animation if the user wants it, and print.

``fly_recorded`` opens each file before the flight and completes it afterwards. If a file cannot be
written, the error names it.
"""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mrsfi_runtime.analysis import tables
from mrsfi_runtime.cli.options import FlightFiles
from mrsfi_runtime.cli.terminal import flight_progress, print_json, print_table, print_words, tell
from mrsfi_runtime.cosimulation.lockstep import Observer
from mrsfi_runtime.engine.flights import Engine, PlainEngine
from mrsfi_runtime.files import whole_file, writable, written_file
from mrsfi_runtime.kernel.flight import initial_state
from mrsfi_runtime.kernel.injections import FaultTally
from mrsfi_runtime.model.faults import FaultPool, Gate, Specification
from mrsfi_runtime.model.mission import Mission, Outcome
from mrsfi_runtime.project_file import installed_version
from mrsfi_runtime.record.observers import (
    Events,
    NamedFault,
    SimulationLog,
    TraceTable,
    named_faults,
)

if TYPE_CHECKING:
    from mrsfi_runtime.engine.recording import Recording

_NOWHERE = Path()


@dataclass(frozen=True, slots=True)
class Subject:
    """The title of a flight, the command that flies it again, and its specification as XMI."""

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
    mission = engine.code.mission
    specification = Gate(mission, pool).admitted(specification)
    faults = named_faults(mission, pool, specification)
    tallies = [FaultTally() for _ in specification]
    with ExitStack() as opened:
        observers = [*_observers(opened, engine, files, faults, tallies)]
        page, animation = (
            None if path is None else opened.enter_context(whole_file(path))
            for path in (files.html, files.gif)
        )
        if page or animation:
            from mrsfi_runtime.engine.recording import Recorder  # brings numpy

            recorder = Recorder(initial_state(mission, engine.seed))
            observers.append((_NOWHERE, recorder))

        def observe(*tick: Any) -> None:
            for path, observer in observers:
                with writable(path):  # otherwise the error would blame the mission
                    observer(*tick)

        observer = observe if observers else None
        outcome = engine.evaluate(specification, pool=pool, observer=observer, tallies=tallies)
        if page:
            page.write(_page(engine, faults, subject, outcome, recorder.recording(tallies)))
        if animation:
            from mrsfi_runtime.analysis.plots import flight_gif
            from mrsfi_runtime.analysis.story import story_of

            recording = recorder.recording(tallies)
            animation.write(flight_gif(story_of(subject.title, mission, faults, recording)))
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
    """Print the violations of each goal, and the faults; as JSON if there is a ``head``."""
    faults = named_faults(mission, pool, specification)
    if head is not None:
        goals = tables.goals_as_json(mission, outcome)
        flown = outcome.repetition
        beside = {} if flown is None else {"flights": flown.n_flights, "late": flown.n_late}
        listed = {"goals": goals, "faults": tables.faults_as_json(faults, outcome)}
        print_json({**head, **beside, **listed})
        return
    print_table(tables.goal_table(title, mission, outcome))
    for words in (tables.nearest_in_words, tables.late_in_words):
        if text := words(mission, outcome):
            print_words(text)
            print_words("")
    if faults:
        print_table(tables.fault_table("Faults", faults, outcome))


def _observers(
    opened: ExitStack,
    engine: Engine,
    files: FlightFiles,
    faults: Sequence[NamedFault],
    tallies: Sequence[FaultTally],
) -> Iterator[tuple[Path, Observer]]:
    """Yield the observers of each tick, each after the file that it writes."""
    mission = engine.code.mission
    if isinstance(engine, PlainEngine):  # others are quick
        yield _NOWHERE, flight_progress(mission.duration)
    if files.log is not None:
        log = opened.enter_context(written_file(files.log))
        yield files.log, SimulationLog(mission, log, Events(mission, faults, tallies))
    if files.trace is not None:
        trace = opened.enter_context(written_file(files.trace))
        yield files.trace, TraceTable(mission, trace)
    if files.mcap is not None:
        yield files.mcap, opened.enter_context(_bag(files.mcap, mission, faults, tallies))


@contextmanager
def _bag(
    path: Path, mission: Mission, faults: Sequence[NamedFault], tallies: Sequence[FaultTally]
) -> Iterator[Observer]:
    from mrsfi_runtime.record.observers import Bag

    with whole_file(path) as file:
        bag = Bag(mission, file, faults, Events(mission, faults, tallies))
        yield bag
        bag.finish()


def _page(
    engine: Engine,
    faults: Sequence[NamedFault],
    subject: Subject,
    outcome: Outcome,
    recording: "Recording",
) -> bytes:
    from mrsfi_runtime.analysis.page import PageEntry, document, flight_page

    mission = engine.code.mission
    told = PageEntry(subject.title, faults, (), outcome, subject.command, subject.xmi)
    facts = {
        "mission": mission.name,
        "ticks": mission.duration,
        "mission seed": engine.seed,
        "mrsfi": installed_version("mrsfi"),
        "digest": outcome.digest,
    }
    return document(flight_page(mission, told, recording, facts.items())).encode()
