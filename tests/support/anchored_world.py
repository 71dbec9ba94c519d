"""A world in which nothing moves: it starts a program, samples by itself, and is late.

``python tests/support/anchored_world.py --mission … --url …`` prints the process ID of its program
first. It is what a team would write, and so imports only what ``examples/worlds`` has.
"""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

sys.path.append(str(Path(__file__).parents[2] / "examples" / "worlds"))

from programs import end, start
from robots import Mission, Physics, Sensor
from serving import serve


class Anchored(Physics):
    """Each sensor takes three samples a tick, of which two are valid."""

    @staticmethod
    def add_options(parser: argparse.ArgumentParser) -> None:
        parser.add_argument("--late", type=int, default=0)

    def __init__(self, mission: Mission, options: argparse.Namespace) -> None:
        self._n = len(mission.robots)
        self.late = options.late
        self._program = start([sys.executable, "-c", "import time; time.sleep(600)"])
        sys.stdout.write(f"{self._program.pid}\n")
        sys.stdout.flush()

    def reset(self, _seed: int) -> None:
        pass

    def move(self) -> Sequence[float]:
        return [0.0] * self._n

    def measured(self, _sensor: Sensor) -> tuple[int, int]:
        return 3, 2

    def close(self) -> None:
        end(self._program)


if __name__ == "__main__":
    sys.exit(serve("an anchor", Anchored))
