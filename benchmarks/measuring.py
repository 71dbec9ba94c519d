"""What benchmarks share: specifications, child processes, growth, other programs, aims."""

import json
import math
import os
import subprocess
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from random import Random
from statistics import linear_regression
from typing import Any

from mrsfi_runtime.mission import MissionCode
from mrsfi_runtime.model.faults import Specification
from mrsfi_runtime.search.space import SearchSpace
from mrsfi_runtime.search.specifications import random_specification

MEBI = 1 << 20
_STAT = Path("/proc/stat")


@dataclass(frozen=True)
class Run:
    """What a child process took.

    Attributes
    ----------
    seconds
        From its start to its end.
    processor
        Seconds of processors, its own children's included.
    peak
        Most memory that it, or one of its own children, held, in bytes.
    output
        What it wrote to standard output.
    """

    seconds: float
    processor: float
    peak: int
    output: str

    def found(self) -> Any:
        """Return the JSON of the last line."""
        return json.loads(self.output.splitlines()[-1])


def run(*words: str, environment: dict[str, str] | None = None) -> Run:
    """Run a Python module in a process of its own to its end.

    Raises
    ------
    SystemExit
        If it fails.
    """
    start = time.perf_counter()
    with subprocess.Popen(
        [sys.executable, "-m", *words],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        encoding="utf-8",
        env=os.environ | (environment or {}),
    ) as process:
        assert process.stdout is not None
        assert process.stderr is not None
        output = process.stdout.read()
        told = process.stderr.read()  # short: the progress of a search fits into the pipe
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
    seconds = time.perf_counter() - start
    if process.returncode:
        message = f"{' '.join(words)} failed:\n{told}"
        raise SystemExit(message)
    return Run(seconds, usage.ru_utime + usage.ru_stime, usage.ru_maxrss * 1024, output)


def drawn(code: MissionCode, n: int, n_faults: int = 20) -> list[Specification]:
    """Return random specifications, the same for the same code."""
    space = SearchSpace.of(code.mission, code.pool)
    return [random_specification(space, n_faults, Random(seed)) for seed in range(n)]


def exponent(sizes: Sequence[float], costs: Sequence[float]) -> float:
    """Return k of the power law cost ~ size ** k that fits best: 1 is linear."""
    slope, _ = linear_regression([math.log(s) for s in sizes], [math.log(c) for c in costs])
    return slope


class Others:
    """What other programs take of this machine while something is measured."""

    def __init__(self) -> None:
        self._begin = time.monotonic()
        self._seconds = self._now()

    def processors(self) -> float:
        """Return how many processors others kept busy since the beginning."""
        return (self._now() - self._seconds) / (time.monotonic() - self._begin)

    @staticmethod
    def _now() -> float:
        """Return the seconds that others have used: all, but for this process and its children."""
        user, nice, system, _, _, *interrupts = map(int, _STAT.read_text("ascii").split()[1:8])
        own = os.times()
        busy = (user + nice + system + sum(interrupts)) / os.sysconf("SC_CLK_TCK")
        return busy - own.user - own.system - own.children_user - own.children_system


class Aims:
    """Prints whether aims are reached, and remembers."""

    def __init__(self) -> None:
        self.missed: list[str] = []

    def below(self, what: str, found: float, limit: float, unit: str) -> None:
        """Print a figure that is to stay below a limit."""
        is_reached = found < limit
        verdict = "reached" if is_reached else "MISSED"
        print(f"{what:58} {found:8.2f} {unit:5} aim < {limit:g}: {verdict}")
        if not is_reached:
            self.missed.append(what)

    def exit_code(self) -> int:
        """Print what is missed; return 1 if anything is."""
        if self.missed:
            print(f"missed: {'; '.join(self.missed)}")
        return 1 if self.missed else 0
