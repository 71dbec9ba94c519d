"""Draw a fault pool that nobody chose, to compare searches where none was tuned.

Run as ``python benchmarks/unseen.py MODEL_DIR SEED OUT_DIR [--pairs]``; ``OUT_DIR`` is new and
gets the mission of ``MODEL_DIR``, its campaign files, and a pool with one fault of every type,
whose target and values are drawn. ``mrsfi generate OUT_DIR`` makes it ready for ``mrsfi compare``.
With ``--pairs`` it also gets a campaign for every two goals, ``case_FIRST-SECOND.toml``, on their
masked violations.
"""

import argparse
import shutil
from collections.abc import Iterator
from itertools import combinations
from pathlib import Path
from random import Random

from m2t.metamodels import load_metamodels
from m2t.models.load import load_mission_folder

_HEAD = """<?xml version="1.0" encoding="ASCII"?>
<faults:FaultSpecification xmi:version="2.0" xmlns:xmi="http://www.omg.org/XMI" \
xmlns:faults="http://mrsfi.org/faults/1.0" ID="drawn">
"""
_LARGEST_VALUE = 60
_CAMPAIGN = """[search]
fitness = "focused"
goals = ["{}", "{}"]
violations = "masked"
"""


def draw_pool(models: Path, seed: int) -> str:
    """Return the XMI of a pool for the mission of a folder; the same seed draws the same."""
    mission = load_mission_folder(models).mission
    robots = list(mission.robots)
    targets = {
        "message": [message.ID for goal in mission.goals for message in goal.messages],
        "robot": [robot.ID for robot in robots],
        "sensor": [sensor.ID for robot in robots for sensor in robot.sensors],
        "obstacle": [obstacle.ID for obstacle in mission.obstacles],
    }
    return "".join([_HEAD, *_faults(targets, Random(seed)), "</faults:FaultSpecification>\n"])


def _faults(targets: dict[str, list[str]], rng: Random) -> Iterator[str]:
    for number, (name, kind) in enumerate(load_metamodels().fault_types.items(), 1):
        target = rng.choice(targets[kind.struck.value])
        values = sorted(rng.randint(1, _LARGEST_VALUE) for _ in kind.parameters)
        given = "".join(
            f' {parameter.name}="{value}"'
            for parameter, value in zip(kind.parameters, values, strict=True)
        )
        tag = name[0].lower() + name[1:]
        yield (
            f'  <faults ID="f{number}" name="f{number}">\n    <{tag}{given}>\n'
            f'      <affected{kind.struck.value.capitalize()} href="mission.xmi#{target}"/>\n'
            f"    </{tag}>\n  </faults>\n"
        )


def main() -> None:
    """Write a folder with the mission of another one and a drawn pool."""
    parser = argparse.ArgumentParser(description="Draw a fault pool that nobody chose.")
    parser.add_argument("models", type=Path, help="folder of the mission")
    parser.add_argument("seed", type=int, help="of the pool")
    parser.add_argument("out", type=Path, help="new folder")
    parser.add_argument("--pairs", action="store_true", help="add a campaign for every two goals")
    arguments = parser.parse_args()
    models, out = arguments.models, arguments.out
    if out.exists():
        parser.error(f"{out} exists; expected a new folder")
    pool = draw_pool(models, arguments.seed)
    out.mkdir(parents=True)
    for file in (models / "mission.xmi", *sorted(models.glob("case_*.toml"))):
        shutil.copy(file, out)
    (out / "faults.xmi").write_text(pool, encoding="ascii")
    goals = [goal.ID for goal in load_mission_folder(models).mission.goals]
    for pair in combinations(goals, 2) if arguments.pairs else ():
        path = out / f"case_{'-'.join(pair)}.toml"
        path.write_text(_CAMPAIGN.format(*pair), encoding="ascii")


if __name__ == "__main__":
    main()
