"""What benchmarks share: specifications, child processes, growth, other programs, aims."""

import json
import math
import os
import subprocess
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from random import Random
from statistics import linear_regression
from typing import Any

from mrsfi_runtime.generated_code import MissionCode
from mrsfi_runtime.model.faults import Specification
from mrsfi_runtime.search.space import SearchSpace, random_specification

MEBI = 1 << 20
_STAT = Path("/proc/stat")


@dataclass(frozen=True)
class Run:
    """What a child process took, its own children included."""

    seconds: float  # from its start to its end
    processor: float  # seconds
    peak: int  # bytes of memory
    lines: tuple[tuple[float, str], ...]  # what it wrote, with the seconds from its start

    def found(self) -> Any:
        """Return the JSON of the last line."""
        return json.loads(self.lines[-1][1])


def run(*words: str) -> Run:
    """Run a Python module in a process of its own to its end; see ``run_in``."""
    return run_in(Path.cwd(), [sys.executable, "-m", *words], os.environ)


def run_in(
    folder: Path, words: Sequence[str], environment: Mapping[str, str], last: str | None = None
) -> Run:
    """Run a command in a folder to its end, or kill it when it prints a line that begins so.

    It counts as ended when its children have let go of its output, too. Whatever fails, or ends
    without that line, ends this process as well.
    """
    start = time.perf_counter()
    lines: list[tuple[float, str]] = []
    is_reached = last is None
    with subprocess.Popen(
        words,
        cwd=folder,
        env=environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        encoding="utf-8",
    ) as process:
        assert process.stdout is not None
        for line in process.stdout:
            lines.append((time.perf_counter() - start, line))
            if last is not None and line.startswith(last):
                is_reached = True
                process.kill()
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
    seconds = time.perf_counter() - start
    if not is_reached or (last is None and process.returncode):
        told = "".join(line for _, line in lines)
        message = f"{folder}: {' '.join(words)} failed:\n{told}"
        raise SystemExit(message)
    processor = usage.ru_utime + usage.ru_stime
    return Run(seconds, processor, usage.ru_maxrss * 1024, tuple(lines))


def seconds(function: Callable[[], object]) -> float:
    """Return how long a call takes."""
    start = time.perf_counter()
    function()
    return time.perf_counter() - start


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
