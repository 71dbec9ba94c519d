"""A mission in Gazebo Fortress, in one of two arrangements.

With ``gate_sea``, Gazebo's server runs inside the gate, and vehicles dive in Gazebo's sea. With
``gate_topics``, an unchanged Gazebo (``--server``) is driven over its own topics. Each flight has a
new server, because Fortress resets no models, and a partition of its own, so that several worlds
fly on one machine.
"""

import argparse
import os
import secrets
import shlex
import subprocess
import sys
from collections.abc import Iterable, Sequence
from contextlib import ExitStack
from pathlib import Path
from string import Template
from tempfile import TemporaryDirectory

sys.path.append(str(Path(__file__).parents[1]))

from gates import Gate
from programs import end, start
from robots import Mission, Obstacle, Physics, WorldError
from serving import serve

HERE = Path(__file__).parent
HEIGHT_M = 20.0
WALL_M = 0.1


class Gazebo(Physics):
    """Vehicles that Gazebo moves; obstacles stand still, and stop them."""

    @staticmethod
    def add_options(parser: argparse.ArgumentParser) -> None:
        """Add gate, server, steps and scale."""
        parser.add_argument("--gate", type=Path, required=True, help="gate_sea or gate_topics")
        parser.add_argument("--server", help="for gate_topics: 'ign gazebo -s', without the world")
        parser.add_argument("--steps", type=int, default=20, help="of a tick")
        parser.add_argument("--unit", type=float, default=1.0, help="metres a distance unit")

    def __init__(self, mission: Mission, options: argparse.Namespace) -> None:
        if not options.gate.is_file():
            raise WorldError(f"--gate: found no file {options.gate}; compile it (README.md)")
        self._mission = mission
        self._options = options
        self._folder = TemporaryDirectory()
        self._world = Path(self._folder.name) / "mission.sdf"
        self._world.write_text(self._sdf(), encoding="utf-8")
        self._flight = ExitStack()

    def reset(self, _seed: int) -> None:
        """Start Gazebo anew, paused before its first step."""
        self._flight.close()
        options = self._options
        names = {"IGN_IP": "127.0.0.1", **os.environ, "IGN_PARTITION": secrets.token_hex(8)}
        words = [options.gate.absolute(), self._world, str(options.steps)]
        if options.server:
            server = [*shlex.split(options.server), self._world]
            self._flight.callback(end, start(server, stdout=subprocess.DEVNULL, env=names))
        words += [robot.name for robot in self._mission.robots]
        self._gate = Gate(self._mission.robots, options.unit, words, env=names)
        self._flight.callback(self._gate.close)

    def move(self) -> Sequence[float]:
        """Step Gazebo for a tick; return the distance of each vehicle."""
        ways, self.late = self._gate.fly()
        return ways

    def close(self) -> None:
        """End Gazebo."""
        self._flight.close()
        self._folder.cleanup()

    def _sdf(self) -> str:
        """Return the world with all models in it."""
        kind = "topics" if self._options.server else "sea"
        steps, unit_m = self._options.steps, self._options.unit
        models = [
            _filled(
                kind,
                name=robot.name,
                place=_text(unit_m * each for each in robot.start),
                radius=unit_m * robot.radius,
                frequency=steps,
            )
            for robot in self._mission.robots
        ]
        for each in self._mission.obstacles:
            models += _fixed(each, unit_m)
        return _filled("world", step_s=1.0 / steps, models="\n".join(models))


def _fixed(obstacle: Obstacle, unit_m: float) -> Iterable[str]:
    """Yield a cylinder, or the walls of a polygon."""
    if not obstacle.corners:
        radius = f"<radius>{obstacle.radius * unit_m}</radius>"
        shape = f"<cylinder>{radius}<length>{HEIGHT_M}</length></cylinder>"
        place = _text(unit_m * each for each in obstacle.center)
        yield _filled("obstacle", name=obstacle.name, place=place, angle=0.0, shape=shape)
    for n, wall in enumerate(obstacle.walls):
        shape = f"<box><size>{wall.length * unit_m} {WALL_M} {HEIGHT_M}</size></box>"
        place = _text(unit_m * each for each in wall.middle)
        name = f"{obstacle.name}_{n}"
        yield _filled("obstacle", name=name, place=place, angle=wall.angle, shape=shape)


def _filled(file: str, **words: object) -> str:
    return Template((HERE / f"{file}.sdf").read_text(encoding="utf-8")).substitute(words)


def _text(numbers: Iterable[float]) -> str:
    return " ".join(map(repr, numbers))


if __name__ == "__main__":
    sys.exit(serve("Gazebo", Gazebo))
