"""The command ``mrsfi simulate``: one flight, or one for each fault of the pool."""

import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import click

from mrsfi_runtime.analysis.effects import audit
from mrsfi_runtime.cli.console import print_json, tell, written_file
from mrsfi_runtime.cli.engines import (
    SIMULATION,
    EngineOptions,
    engine_options,
    fly_recorded,
    recording_options,
)
from mrsfi_runtime.cli.fault_effects import Effects
from mrsfi_runtime.cli.folders import find_mission, generated_option, mission_argument
from mrsfi_runtime.cli.loading import load_fresh, read_specification
from mrsfi_runtime.cli.tables import fault_tables, faults_as_json, goal_table, goals_as_json
from mrsfi_runtime.cli.terminal import print_table
from mrsfi_runtime.engine.settings import AUTO, REFERENCE, ROSBRIDGE, EngineSettings
from mrsfi_runtime.errors import UsageError
from mrsfi_runtime.mission import MissionCode
from mrsfi_runtime.model.mission import Mission
from mrsfi_runtime.model.outcome import Outcome
from mrsfi_runtime.record.manifest import BOTH, CI
from mrsfi_runtime.record.named_faults import NamedFault, named_faults
from mrsfi_runtime.transport.server_address import without_token

_HELP = """Fly MISSION once and print what happened to each goal.

Without --faults it flies without faults. A fault specification is XMI: one that search found
(runs/NAME/critical/01.xmi), or one written by hand: a copy of the pool whose faults have
start and finish.

\b
Examples:
  mrsfi simulate uuv_sampling
  mrsfi simulate uuv_sampling --seed 7 --log flight.log --trace flight.csv
  mrsfi simulate uuv_sampling --faults runs/uuv_sampling-a-1/critical/01.xmi
  mrsfi simulate uuv_sampling --each-fault 100:900
  mrsfi simulate uuv_sampling --each-fault 100:900 --seeds 40 --markdown effects.md
  mrsfi simulate uuv_sampling --engine rosbridge

\b
On a server of yours, simulation and collective intelligence apart:
  mrsfi bridge --port 9090
  mrsfi simulate uuv_sampling --engine rosbridge --url ws://127.0.0.1:9090 --side simulation
  mrsfi simulate uuv_sampling --engine rosbridge --url ws://127.0.0.1:9090 --side ci

A violation counts once per goal and tick: believed by the collective intelligence, true in
the simulation, phantom (believed, not true), masked (true, not believed). A goal is missed from
the tick on at which it is certain, from the truth alone, that its purpose is not met; – if it was
met.
"""

_WINDOW = re.compile(r"(\d+):(\d+)")


@click.command(name="simulate", help=_HELP)
@mission_argument
@generated_option
@click.option("--no-faults", is_flag=True, help="Fly without faults, as without this option.")
@click.option(
    "--faults",
    type=click.Path(path_type=Path, dir_okay=False),
    metavar="FILE",
    help="Fly under this fault specification.",
)
@click.option(
    "--each-fault",
    metavar="START:FINISH",
    help="Fly with each fault of the pool alone, active in these ticks; what changes no goal "
    "also with other values, unless over rosbridge. The engine is auto without --engine.",
)
@click.option(
    "--markdown",
    type=click.Path(path_type=Path, dir_okay=False),
    metavar="FILE",
    help="With --each-fault: write the page to FILE.",
)
@click.option(
    "--seeds",
    "n_seeds",
    type=click.IntRange(1),
    default=1,
    show_default=True,
    help="With --each-fault: fly in so many mission seeds, from --seed on.",
)
@click.option(
    "--seed", type=click.IntRange(0), default=1, show_default=True, help="Seed of the weather."
)
@recording_options
@engine_options(BOTH, CI, SIMULATION)
@click.option("--json", "is_json", is_flag=True, help="Print the result for a script.")
def command(  # noqa: PLR0913 - one parameter per option
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
    log: Path | None,
    trace: Path | None,
    is_json: bool,
) -> None:
    """Fly a mission once and print what happened to each goal."""
    ways = [way for way in (no_faults or None, faults, each_fault) if way is not None]
    _require_one_way(ways, is_each=each_fault is not None, has_log=bool(log or trace))
    if each_fault is None and (markdown is not None or n_seeds > 1):
        option = "--seeds" if markdown is None else "--markdown"
        raise click.UsageError(f"{option} needs --each-fault")
    settings = engine.settings(default=REFERENCE if each_fault is None else AUTO)
    folders = find_mission(mission, generated)
    code = load_fresh(folders)
    if engine.side == SIMULATION:
        _require_nothing_else(ways, is_json=is_json, has_log=bool(log or trace))
        _serve(folders.name, code, settings)
        return
    if settings.name == AUTO:
        settings = settings.tried(code, seed, tell)
    with settings.open(code, seed) as opened:
        if each_fault is not None:
            window = _window(each_fault)
            tries_values = settings.name != ROSBRIDGE
            rows = audit(opened, *window, n_seeds, tries_values=tries_values)
            name, found = folders.name, code.mission
            effects = Effects(name, found, seed, n_seeds, *window, rows, tries_values)
            _tell_effects(effects, markdown, is_json=is_json)
            return
        pool = code.pool if faults is None else read_specification(faults)[1]
        specification = () if faults is None else pool.written_specification()
        outcome = fly_recorded(opened, specification, pool, log, trace)
    named = named_faults(code.mission, pool, specification)
    if is_json:
        print_json(_as_json(code.mission, seed, named, outcome))
        return
    flown = "without faults" if faults is None else f"under {faults}"
    title = f"{folders.name}, {code.mission.duration} ticks, seed {seed}, {flown}"
    print_table(title, goal_table(code.mission, outcome))
    if named:
        print_table("Faults", *fault_tables(named, outcome))


def _require_one_way(ways: Sequence[object], *, is_each: bool, has_log: bool) -> None:
    if len(ways) > 1:
        raise click.UsageError("--no-faults, --faults and --each-fault exclude each other")
    if is_each and has_log:
        raise click.UsageError("--log and --trace record one flight; --each-fault flies many")


def _require_nothing_else(ways: Sequence[object], *, is_json: bool, has_log: bool) -> None:
    if ways or is_json or has_log:
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


def _tell_effects(effects: Effects, markdown: Path | None, *, is_json: bool) -> None:
    if markdown is not None:
        with written_file(markdown) as file:
            file.write(effects.page())
        tell(f"written    {markdown}")
    if is_json:
        print_json(effects.as_json())
    elif markdown is None:
        print_table(effects.title, effects.table())
