"""Gates: programs between a world and a simulator that only talks C++."""

import subprocess
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

from programs import end, start
from robots import Robot


class Gate:
    """A gate, which answers a line on its standard input by a line on its standard output.

    It begins with ``ready``, and ends when its input does. ``fly X Y …`` has the velocity that each
    robot is commanded, in m/s; after a second of the simulator the answer has ``x y z speed way``
    of each robot, in metres, and at its end how many commands came too late.
    """

    def __init__(
        self, robots: Sequence[Robot], unit_m: float, words: Sequence[str | Path], **options: Any
    ) -> None:
        self._robots = robots
        self._unit_m = unit_m
        self._program = start(words, stdin=subprocess.PIPE, stdout=subprocess.PIPE, **options)
        try:
            self._expect_ready(self._read())
        except OSError:
            end(self._program)
            raise

    def ask_ready(self, verb: str, numbers: Sequence[float] = ()) -> None:
        """Have the gate do something that it answers by ``ready``; numbers are distances."""
        self._expect_ready(self._ask(verb, numbers))

    def fly(self) -> tuple[list[float], int]:
        """Fly a tick; return the distance of each robot, and how many commands came too late."""
        wanted = [robot.wanted_speed * each for robot in self._robots for each in robot.heading]
        *told, late = map(float, self._ask("fly", wanted))
        ways = []
        for robot, five in zip(self._robots, zip(*[iter(told)] * 5, strict=True), strict=True):
            x, y, z, robot.speed, way = (metres / self._unit_m for metres in five)
            robot.position = x, y, z
            ways.append(way)
        return ways, int(late)

    def close(self) -> None:
        """End the gate."""
        end(self._program)

    def _ask(self, verb: str, numbers: Sequence[float]) -> list[str]:
        words = [verb, *(repr(float(number * self._unit_m)) for number in numbers)]
        with suppress(BrokenPipeError):  # reading tells that it has ended
            print(*words, file=self._program.stdin, flush=True)
        return self._read()

    def _read(self) -> list[str]:
        line = self._program.stdout.readline()
        if not line:
            raise OSError(f"{self._program.args[0]} ended with {self._program.wait()}")
        return line.split()

    def _expect_ready(self, answer: list[str]) -> None:
        if answer != ["ready"]:
            raise OSError(f"{self._program.args[0]} answered {answer}; expected ready")
