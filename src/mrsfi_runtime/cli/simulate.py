"""The command ``mrsfi simulate``."""

from pathlib import Path
from typing import TYPE_CHECKING

import click

from mrsfi.engines import Given, chosen
from mrsfi_runtime.cli.console import tell
from mrsfi_runtime.cli.options import (
    SIMULATION,
    FlightFiles,
    engine_options,
    file_option,
    generated_option,
    mission_argument,
    recording_options,
)
from mrsfi_runtime.engine.opening import named, open_engine
from mrsfi_runtime.record.engine_settings import BOTH, CI, INJECTOR, EngineSettings

if TYPE_CHECKING:
    from mrsfi_runtime.generated_code import MissionCode
    from mrsfi_runtime.model.faults import FaultPool, Specification


@click.command(name="simulate")
@mission_argument
@generated_option
@click.option("--no-faults", is_flag=True, help="Fly without faults, as without this option.")
@file_option("--faults", "Fly under this fault specification.")
@click.option("--seed", type=click.IntRange(0), default=1, show_default=True, help="Mission seed.")
@recording_options
@engine_options(sides=(BOTH, CI, INJECTOR, SIMULATION))
@click.option("--json", "is_json", is_flag=True, help="Print the result for a script.")
def command(
    mission: str,
    generated: Path | None,
    engine: Given,
    no_faults: bool,
    faults: Path | None,
    seed: int,
    files: FlightFiles,
    is_json: bool,
) -> None:
    """Fly MISSION once and print what happened to each goal.

    Without --faults it flies without faults. A fault specification is XMI: one that search found
    (runs/NAME/critical/01.xmi), or one written by hand: a copy of the pool whose faults have
    start and finish.

    \b
    Examples:
      mrsfi simulate uuv_sampling
      mrsfi simulate uuv_sampling --seed 7 --log flight.log --trace flight.csv
      mrsfi simulate uuv_sampling --faults runs/uuv_sampling-a-1/critical/01.xmi
      mrsfi simulate uuv_sampling --engine rosbridge

    \b
    On a server of yours, simulation and collective intelligence apart:
      mrsfi bridge --port 9090
      mrsfi simulate uuv_sampling --engine rosbridge --url ws://127.0.0.1:9090 --side simulation
      mrsfi simulate uuv_sampling --engine rosbridge --url ws://127.0.0.1:9090 --side ci

    A violation counts once per goal and tick: believed by the collective intelligence, true in the
    simulation, phantom (believed, not true), masked (true, not believed). A goal is missed from the
    tick on at which it is certain, from the truth alone, that its purpose is not met; – if it was
    met.
    """
    from mrsfi.folders import find_mission
    from mrsfi.loading import load_fresh, read_specification
    from mrsfi_runtime.cli.recorded_flight import Subject, fly_recorded, print_flight

    if no_faults and faults is not None:
        raise click.UsageError("--no-faults and --faults exclude each other")
    settings = chosen(engine)
    folders = find_mission(mission, generated)
    code = load_fresh(folders)
    if settings.side == SIMULATION:
        if no_faults or faults is not None or files.wanted or is_json:
            raise click.UsageError(
                "--side simulation flies what the other side tells it; give faults, logs and "
                "--json there"
            )
        _serve(folders.name, code, settings)
        return
    again, flown, text = ["mrsfi", "simulate", mission], "without faults", ""
    pool: FaultPool = code.pool
    specification: Specification = ()
    if faults is not None:
        written = read_specification(faults, code, tell)
        pool, specification, flown = written.pool, written.specification, f"under {faults}"
        again += ["--faults", str(faults)]
        text = faults.read_text(encoding="utf-8", errors="replace")
    lasts = code.mission.units.ticks(code.mission.duration)
    title = f"{folders.name}, {lasts}, seed {seed}, {flown}"
    with open_engine(named(settings, code, seed, tell), code, seed) as flown_by:
        subject = Subject(title, [*again, "--seed", str(seed)], text)
        outcome = fly_recorded(flown_by, specification, pool, files, subject)
    head = {"mission": code.mission.name, "duration": code.mission.duration, "seed": seed}
    head["digest"] = outcome.digest
    print_flight(code.mission, pool, specification, outcome, title, head if is_json else None)


def _serve(name: str, code: "MissionCode", settings: EngineSettings) -> None:
    from mrsfi_runtime.engine.rosbridge import serve_simulation
    from mrsfi_runtime.transport.topics import without_token

    def on_ready(url: str, _host: object) -> None:
        tell(f"simulation of {name} serves at {without_token(url)}; Ctrl-C ends it")

    serve_simulation(code, settings, on_ready)
