"""How many goals are violated without faults, if robots turn slowly and report inexact positions.

Run ``python -m benchmarks.turning`` from the project's folder; it prints the table of
``benchmarks/results/turning.md``. All robots of a mission get the attributes, and the compiled
engine flies it without faults in mission seeds 1 to 30.
"""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from mrsfi_runtime.engine.opening import open_engine
from mrsfi_runtime.generated_code import load_code
from mrsfi_runtime.record.engine_settings import EngineSettings

MISSIONS = ("uuv_sampling", "tight_energy", "undersea", "fleet_30", "tight_margins", "atlas_search")
SEEDS = range(1, 31)
ROBOTS: Mapping[str, Mapping[str, Any]] = {
    "neither": {},
    "turn rate 90": {"turn_rate": 90.0},
    "turn rate 45": {"turn_rate": 45.0},
    "turn rate 10": {"turn_rate": 10.0},
    "noise 1": {"position_noise": 1.0},
    "noise 2": {"position_noise": 2.0},
    "turn rate 45 and noise 1": {"turn_rate": 45.0, "position_noise": 1.0},
    "turn rate 10 and noise 2": {"turn_rate": 10.0, "position_noise": 2.0},
}


def cell(mission: str, given: Mapping[str, Any]) -> str:
    """Return the mean numbers of goals truly violated and failed, and the tasks of all of them."""
    code = load_code(Path("generated") / mission)
    robots = tuple(replace(robot, **given) for robot in code.mission.robots)
    code = replace(code, mission=replace(code.mission, robots=robots))
    violated = failed = 0
    tasks: set[str] = set()
    with open_engine(EngineSettings("compiled"), code, SEEDS[0]) as engine:
        for seed in SEEDS:
            outcome = engine.evaluate((), seed)
            violated += sum(map(bool, outcome.true))
            failed += sum(map(bool, outcome.missed))
            pairs = zip(code.mission.goals, outcome.true, outcome.missed, strict=True)
            tasks |= {goal.task.name for goal, true, missed in pairs if true or missed}
    if not tasks:
        return "0"
    means = f"{violated / len(SEEDS):.1f} ({failed / len(SEEDS):.1f})"
    return f"{means}: {', '.join(sorted(tasks))}"


def main() -> None:
    """Print a row for each setting, and a column for each mission."""
    print(f"| Of each robot | {' | '.join(f'`{each}`' for each in MISSIONS)} |")
    print("|---" * (1 + len(MISSIONS)) + "|")
    for words, given in ROBOTS.items():
        print(f"| {words} | {' | '.join(cell(each, given) for each in MISSIONS)} |", flush=True)


if __name__ == "__main__":
    main()
