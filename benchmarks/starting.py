"""What commands take from process start, beside an installed copy of another commit.

Make the copy first, as ``make install`` does, then run ``python -m benchmarks.starting COPY``:

    git worktree add --detach ../before 6403a3e && make -C ../before install

Both take turns, ``--rounds`` times after one that fills the caches of compiled code and bytecode.
Printed are medians, and ratios of medians: seconds until the last line of the result is printed,
until the process has ended, and of processors, those of its children included.
"""

import argparse
import os
import subprocess
import tempfile
import time
from dataclasses import astuple, dataclass
from pathlib import Path
from statistics import median

from benchmarks.measuring import Others

MISSION = "uuv_sampling"
COMMANDS = {
    "--help": (),
    "validate": (MISSION,),
    "generate": (MISSION, "--check"),
    "evolve": (MISSION, "--no-explain"),
}


@dataclass(frozen=True)
class Taken:
    """Seconds until all was printed, until the end, and of processors."""

    printed: float
    ended: float
    processor: float


def taken(tree: Path, command: str, cache: Path) -> Taken:
    """Run a command of the mrsfi that is installed in a tree; the folder of a search is dropped.

    Raises
    ------
    SystemExit
        If it fails.
    """
    with tempfile.TemporaryDirectory() as name:
        words = [command, *COMMANDS[command]]
        if command == "evolve":
            words += ["--out", f"{name}/run"]
            if not (tree / "src/mrsfi_runtime/causes/recorded.py").is_file():
                words.remove("--no-explain")  # a commit whose search explains nothing
        environment = os.environ | {"MRSFI_CACHE": str(cache)}
        environment.pop("PYTHONDONTWRITEBYTECODE", None)
        start = printed = time.perf_counter()
        with subprocess.Popen(
            [tree / ".venv/bin/python", "-m", "mrsfi_runtime.cli.main", *words],
            cwd=tree,
            env=environment,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            encoding="utf-8",
        ) as process:
            assert process.stdout is not None
            assert process.stderr is not None
            for _ in process.stdout:
                printed = time.perf_counter()
            told = process.stderr.read()  # short: it fits into the pipe
            _, status, usage = os.wait4(process.pid, 0)
            process.returncode = os.waitstatus_to_exitcode(status)
        ended = time.perf_counter()
    if process.returncode:
        message = f"{tree}: {' '.join(words)} failed:\n{told}"
        raise SystemExit(message)
    return Taken(printed - start, ended - start, usage.ru_utime + usage.ru_stime)


def print_medians(command: str, before: list[Taken], now: list[Taken]) -> None:
    """Print the medians of a command in the copy and here, and their ratios."""
    for index, what in enumerate(("printed", "ended", "processor")):
        first, second = (median(astuple(each)[index] for each in runs) for runs in (before, now))
        print(f"{command:10} {what:10} {first:8.3f} {second:8.3f} {second / first:6.2f}")


def main() -> None:
    """Print what each command takes in the copy, and here."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("copy", type=Path, help="tree with the other commit installed in .venv")
    parser.add_argument("--rounds", type=int, default=10)
    arguments = parser.parse_args()
    trees = (arguments.copy.resolve(), Path.cwd())
    others = Others()
    print(f"{'':21} {'before':>8} {'now':>8} {'ratio':>6}")
    with tempfile.TemporaryDirectory() as name:
        caches = [Path(name) / "before", Path(name) / "now"]
        for command in COMMANDS:
            runs: tuple[list[Taken], list[Taken]] = ([], [])
            for number in range(arguments.rounds + 1):
                for tree, cache, found in zip(trees, caches, runs, strict=True):
                    once = taken(tree, command, cache)
                    if number:
                        found.append(once)
            print_medians(command, *runs)
    print(f"other programs kept {others.processors():.1f} of {os.cpu_count()} processors busy")


if __name__ == "__main__":
    main()
