"""The command ``mrsfi simulate``: one flight, or one for each fault of the pool."""

import re
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from mrsfi.engines import opened
from mrsfi.folders import find_mission
from mrsfi.loading import load_fresh, read_specification
from mrsfi_runtime.cli.console import print_json, tell
from mrsfi_runtime.cli.engines import SIMULATION, EngineOptions, FlightFiles
from mrsfi_runtime.cli.recorded_flight import Subject, fly_recorded
from mrsfi_runtime.cli.tables import fault_tables, faults_as_json, goal_table, goals_as_json
from mrsfi_runtime.cli.terminal import print_table
from mrsfi_runtime.engine.flights import Engine
from mrsfi_runtime.engine.settings import AUTO, REFERENCE, ROSBRIDGE, EngineSettings
from mrsfi_runtime.errors import UsageError
from mrsfi_runtime.files import written_file
from mrsfi_runtime.mission import MissionCode
from mrsfi_runtime.model.faults import FaultPool, Specification
from mrsfi_runtime.model.mission import Mission
from mrsfi_runtime.model.outcome import Outcome
from mrsfi_runtime.record.named_faults import NamedFault, named_faults
from mrsfi_runtime.transport.server_address import without_token

if TYPE_CHECKING:
    from mrsfi_runtime.cli.fault_effects import Effects

_WINDOW = re.compile(r"(\d+):(\d+)")


def simulate(  # noqa: PLR0913 - one parameter per option
    mission: str,
    generated: Path | None,
    *,
    engine: EngineOptions,
    no_faults: bool,
    faults: Path | None,
    each_fault: str | None,
    markdown: Path | None,
    n_seeds: int,
    seed: int,
    files: FlightFiles,
    is_json: bool,
) -> None:
    """Fly a mission once and print what happened to each goal."""
    ways = [way for way in (no_faults or None, faults, each_fault) if way is not None]
    _require_one_way(ways, files, is_each=each_fault is not None)
    if each_fault is None and (markdown is not None or n_seeds > 1):
        option = "--seeds" if markdown is None else "--markdown"
        raise click.UsageError(f"{option} needs --each-fault")
    settings = engine.settings(default=REFERENCE if each_fault is None else AUTO)
    folders = find_mission(mission, generated)
    code = load_fresh(folders)
    if engine.side == SIMULATION:
        _require_nothing_else(ways, files, is_json=is_json)
        _serve(folders.name, code, settings)
        return
    if settings.name == AUTO:
        settings = settings.tried(code, seed, tell)
    with opened(code, seed, settings, tell) as flown_by:
        if each_fault is not None:
            window = _window(each_fault)
            tries_values = settings.name != ROSBRIDGE
            effects = _effects(folders.name, flown_by, window, n_seeds, tries_values=tries_values)
            _tell_effects(effects, markdown, is_json=is_json)
            return
        pool, specification = _flown(faults, code)
        flown = "without faults" if faults is None else f"under {faults}"
        title = f"{folders.name}, {code.mission.duration} ticks, seed {seed}, {flown}"
        subject = Subject(title, _command(mission, faults, seed), _text(faults))
        outcome = fly_recorded(flown_by, specification, pool, files, subject)
    named = named_faults(code.mission, pool, specification)
    if is_json:
        print_json(_as_json(code.mission, seed, named, outcome))
        return
    print_table(title, goal_table(code.mission, outcome))
    if named:
        print_table("Faults", *fault_tables(named, outcome))


def _flown(path: Path | None, code: MissionCode) -> tuple[FaultPool, Specification]:
    if path is None:
        return code.pool, ()
    written = read_specification(path, code)
    for oddity in written.oddities(path, code.mission):
        tell(oddity)
    return written.pool, written.specification


def _command(mission: str, faults: Path | None, seed: int) -> list[str]:
    """Return what flies the same again."""
    chosen = [] if faults is None else ["--faults", str(faults)]
    return ["mrsfi", "simulate", mission, *chosen, "--seed", str(seed)]


def _text(faults: Path | None) -> str:
    return "" if faults is None else faults.read_text(encoding="utf-8", errors="replace")


def _require_one_way(ways: Sequence[object], files: FlightFiles, *, is_each: bool) -> None:
    if len(ways) > 1:
        raise click.UsageError("--no-faults, --faults and --each-fault exclude each other")
    if is_each:
        files.require_none("--each-fault")


def _require_nothing_else(ways: Sequence[object], files: FlightFiles, *, is_json: bool) -> None:
    if ways or is_json or files.wanted:
        raise click.UsageError(
            "--side simulation flies what the other side tells it; give faults, logs and --json "
            "there"
        )


def _serve(name: str, code: MissionCode, settings: EngineSettings) -> None:
    """Serve the simulation until it is interrupted or the connection is gone."""
    from mrsfi_runtime.engine.simulation_process import (  # noqa: PLC0415 - brings a server
        serve_simulation,
    )

    def on_ready(url: str, _host: object) -> None:
        tell(f"simulation of {name} serves at {without_token(url)}; Ctrl-C ends it")

    serve_simulation(code, settings.url, settings.client, settings.patience, on_ready)


def _window(text: str) -> tuple[int, int]:
    match = _WINDOW.fullmatch(text)
    if match is not None and int(match[1]) <= int(match[2]):
        return int(match[1]), int(match[2])
    raise UsageError(
        f"--each-fault: found '{text}'; expected two ticks START:FINISH, such as 100:900"
    )


def _as_json(
    mission: Mission, seed: int, faults: Sequence[NamedFault], outcome: Outcome
) -> dict[str, Any]:
    return {
        "mission": mission.name,
        "duration": mission.duration,
        "seed": seed,
        "digest": outcome.digest,
        "goals": goals_as_json(mission, outcome),
        "faults": faults_as_json(faults, outcome),
    }


def _effects(
    name: str, engine: Engine, window: tuple[int, int], n_seeds: int, *, tries_values: bool
) -> "Effects":
    """Fly with each fault alone; numpy comes with that, and one flight does without."""
    from mrsfi_runtime.analysis.effects import audit  # noqa: PLC0415 - brings numpy
    from mrsfi_runtime.cli.fault_effects import Effects  # noqa: PLC0415 - brings numpy

    rows = audit(engine, *window, n_seeds, tries_values=tries_values)
    return Effects(name, engine.code.mission, engine.seed, n_seeds, *window, rows, tries_values)


def _tell_effects(effects: "Effects", markdown: Path | None, *, is_json: bool) -> None:
    if markdown is not None:
        with written_file(markdown) as file:
            file.write(effects.page())
        tell(f"written    {markdown}")
    if is_json:
        print_json(effects.as_json())
    elif markdown is None:
        print_table(effects.title, effects.table())
