"""The command ``mrsfi simulate``."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import click

from mrsfi.engines import opened
from mrsfi.folders import find_mission
from mrsfi.loading import load_fresh, read_specification
from mrsfi_runtime.cli.console import print_json, tell
from mrsfi_runtime.cli.engines import SIMULATION, EngineOptions, FlightFiles
from mrsfi_runtime.cli.recorded_flight import Subject, fly_recorded
from mrsfi_runtime.cli.tables import fault_tables, faults_as_json, goal_table, goals_as_json
from mrsfi_runtime.cli.terminal import print_table
from mrsfi_runtime.engine.settings import AUTO, EngineSettings
from mrsfi_runtime.generated_code import MissionCode
from mrsfi_runtime.model.faults import FaultPool, Specification
from mrsfi_runtime.model.mission import Mission
from mrsfi_runtime.model.outcome import Outcome
from mrsfi_runtime.record.named_faults import NamedFault, named_faults
from mrsfi_runtime.transport.server_address import without_token


def simulate(
    mission: str,
    generated: Path | None,
    *,
    engine: EngineOptions,
    no_faults: bool,
    faults: Path | None,
    seed: int,
    files: FlightFiles,
    is_json: bool,
) -> None:
    """Fly a mission once and print what happened to each goal."""
    if no_faults and faults is not None:
        raise click.UsageError("--no-faults and --faults exclude each other")
    settings = engine.settings()
    folders = find_mission(mission, generated)
    code = load_fresh(folders)
    if engine.side == SIMULATION:
        if no_faults or faults is not None or files.wanted or is_json:
            raise click.UsageError(
                "--side simulation flies what the other side tells it; give faults, logs and "
                "--json there"
            )
        _serve(folders.name, code, settings)
        return
    if settings.name == AUTO:
        settings = settings.tried(code, seed, tell)
    with opened(code, seed, settings, tell) as flown_by:
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


def _serve(name: str, code: MissionCode, settings: EngineSettings) -> None:
    """Serve the simulation until it is interrupted or the connection is gone."""
    from mrsfi_runtime.engine.simulation_process import (  # noqa: PLC0415 - brings a server
        serve_simulation,
    )

    def on_ready(url: str, _host: object) -> None:
        tell(f"simulation of {name} serves at {without_token(url)}; Ctrl-C ends it")

    serve_simulation(code, settings.url, settings.client, settings.patience, on_ready)


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
