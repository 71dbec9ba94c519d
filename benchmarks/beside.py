"""How long things take here, beside installed copies of other commits.

Run ``python -m benchmarks.beside`` from the project's root after ``make install``, or with names
of what is to be measured. A copy is made the first time, as a work tree of git with an
environment of its own, and kept. All take turns, so that whatever else slows this machine slows
all alike; printed are the least and the median of each, and their ratios to the first commit. Only
times compare: under other semantics the same mission flies otherwise.
"""

import argparse
import os
import shutil
import statistics
import subprocess
import sys
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from math import ceil
from pathlib import Path
from types import MappingProxyType

from benchmarks.measuring import MEBI, Others, Run, run_in

MISSION = "uuv_sampling"
FLEET = Path("models", "fleet_30")  # of this tree, as old commits lack it
DURATION = 'duration="1000"'
REGION = "    # protected region g3.check on begin\n"
Figures = dict[str, float]
"""What was measured, in words with their unit."""


@dataclass(frozen=True)
class Side:
    """One of the trees compared."""

    tree: Path  # mrsfi is installed in its .venv
    scratch: Path  # for what is made while measuring
    n_evaluations: int  # of the long campaign

    def probe(self, *words: str) -> Figures:
        """Measure from within; see ``benchmarks.probe``."""
        script = str(Path(__file__).with_name("probe.py"))
        found = self._run("python", "-P", script, *words, PYTHONPATH=str(self.tree)).found()
        return {f"{what}, ms": value for what, value in found.items()}

    def mrsfi(self, *words: str, last: str | None = None, folder: str = "cache") -> Run:
        """Run a command, with its compiled code in a folder, until it ends or prints a line."""
        return self._run("mrsfi", *words, last=last, MRSFI_CACHE=str(self.scratch / folder))

    def evolve(
        self,
        *words: str,
        mission: str = MISSION,
        explains: bool = False,
        last: str | None = None,
        folder: str = "cache",
    ) -> Run:
        """Run a search, and drop what it found; it explains nothing unless it is to."""
        if not explains and "--no-explain" in _help(self, "evolve"):
            words = (*words, "--no-explain")
        with tempfile.TemporaryDirectory(dir=self.scratch) as name:
            words = ("evolve", mission, *words, "--out", f"{name}/run")
            return self.mrsfi(*words, last=last, folder=folder)

    def _run(self, program: str, *words: str, last: str | None = None, **variables: str) -> Run:
        environment = os.environ | {"MRSFI_CACHE": str(self.scratch / "cache")} | variables
        environment.pop("PYTHONDONTWRITEBYTECODE", None)
        command = [str(self.tree / ".venv" / "bin" / program), *words]
        return run_in(self.tree, command, environment, last)


@cache
def _help(side: Side, command: str) -> str:
    return "".join(line for _, line in side.mrsfi(command, "--help").lines)


def from_start(what: str, run: Run) -> Figures:
    """Return what a command took."""
    return {
        f"{what}: last line, s": run.lines[-1][0],
        f"{what}: end, s": run.seconds,
        f"{what}: processors, s": run.processor,
    }


def commands(side: Side, _: int) -> Figures:
    """Run what searches nothing."""
    keeps = (side.tree / "models" / MISSION / "regressions").is_dir()
    return {
        **from_start("--help", side.mrsfi("--help")),
        **from_start("validate", side.mrsfi("validate", MISSION)),
        **from_start("generate", side.mrsfi("generate", MISSION, "--check")),
        **from_start("simulate", side.mrsfi("simulate", MISSION)),
        **(from_start("check", side.mrsfi("check", MISSION)) if keeps else {}),
    }


def cold(side: Side, number: int) -> Figures:
    """Search with nothing compiled before."""
    return from_start("evolve, cold", side.evolve(folder=f"cold-{number}"))


def edited(side: Side, number: int) -> Figures:
    """Edit a region, and search until the first generation is on the screen."""
    generated = side.scratch / "generated"
    shutil.rmtree(generated, ignore_errors=True)
    shutil.copytree(side.tree / "generated" / MISSION, generated)
    path = generated / "collective_intelligence.py"
    text = path.read_text("utf-8")
    lines = f"    if ci.mission.tick < -{number + 1}:\n        return False\n"
    if REGION not in text:
        message = f"{path}: found no region g3.check to edit"
        raise SystemExit(message)
    path.write_text(text.replace(REGION, REGION + lines), "utf-8")
    return first_generation("region edit", side, "--generated", str(generated))


def unseen(side: Side, number: int) -> Figures:
    """Search a mission of a size that nobody has flown until the first generation is printed."""
    models = side.scratch / f"unseen-{number}" / "models" / "unseen"
    shutil.copytree(side.tree / "models" / MISSION, models)
    path = models / "mission.xmi"
    text = path.read_text("utf-8")
    if DURATION not in text:
        message = f"{path}: found no {DURATION} to replace"
        raise SystemExit(message)
    path.write_text(text.replace(DURATION, f'duration="{1001 + number}"'), "utf-8")
    side.mrsfi("generate", str(models))
    return first_generation("mission never seen", side, mission=str(models))


def first_generation(what: str, side: Side, *words: str, mission: str = MISSION) -> Figures:
    """Return what a search took until its first generation was printed."""
    found = side.evolve(*words, mission=mission, last="generation")
    return {
        f"{what} to first generation, s": found.lines[-1][0],
        f"{what}: processors, s": found.processor,
    }


def many(side: Side, _: int) -> Figures:
    """Search and report for long."""
    found = side.evolve("--evaluations", str(side.n_evaluations))
    what = f"{side.n_evaluations:,} evaluations"
    return {**from_start(what, found), f"{what}: peak, MiB": found.peak / MEBI}


@dataclass(frozen=True)
class Quantity:
    """What is measured together."""

    measure: Callable[[Side, int], Figures]  # takes the number of the round as well, from 0
    share: int = 1  # rounds for one round of it
    is_warmed: bool = True  # a round goes before those that count


QUANTITIES = MappingProxyType(
    {
        "paper": Quantity(lambda side, _: side.probe()),
        "fleet_30": Quantity(
            lambda side, _: side.probe(str(side.scratch / "fleet_30"), str(FLEET.absolute()))
        ),
        "robots": Quantity(lambda side, _: side.probe(str(side.scratch / "fleet"))),
        "commands": Quantity(commands),
        "cached": Quantity(lambda side, _: from_start("evolve, cached", side.evolve())),
        "weaknesses": Quantity(
            lambda side, _: from_start("evolve, weaknesses", side.evolve(explains=True))
        ),
        "cold": Quantity(cold, share=3, is_warmed=False),
        "edit": Quantity(edited, share=3),
        "unseen": Quantity(unseen, share=3),
        "many": Quantity(many, share=10, is_warmed=False),
    }
)


def print_ratios(found: list[list[Figures]]) -> None:
    """Print a line for each figure: the least and the median of each side."""
    for what in found[0][0]:
        columns = []
        for of in (min, statistics.median):
            first, *others = (of(each[what] for each in runs) for runs in found)
            columns += [f"{first:10.3f}", *(f"{each:10.3f} {each / first:6.2f}" for each in others)]
        print(f"{what:40} {' '.join(columns)}", flush=True)


def installed(commit: str, copy: Path) -> Path:
    """Return a tree with a commit, installed there unless it is already."""
    if not (copy / ".venv" / ".installed").is_file():
        if not copy.exists():
            subprocess.run(
                ("git", "worktree", "add", "--force", "--detach", str(copy), commit), check=True
            )
        subprocess.run(("make", "-C", str(copy), "install", f"PYTHON={sys.executable}"), check=True)
    return copy


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("quantities", nargs="*", help=f"of {', '.join(QUANTITIES)}")
    parser.add_argument("--commit", action="append", help="several may be given [default: 82a3d34]")
    parser.add_argument("--copies", type=Path, default=tempfile.gettempdir(), help="their folder")
    parser.add_argument("--rounds", type=int, default=10, help="fewer of what takes long")
    parser.add_argument("--evaluations", type=int, default=100_000, help="of the long campaign")
    arguments = parser.parse_args()
    unknown = [name for name in arguments.quantities if name not in QUANTITIES]
    if unknown:
        parser.error(f"found '{unknown[0]}'; expected some of: {', '.join(QUANTITIES)}")
    return arguments


def main() -> None:
    """Print how long everything takes in the copy, and here."""
    arguments = _arguments()
    commits = arguments.commit or ["82a3d34"]
    trees = [installed(each, arguments.copies.absolute() / f"mrsfi-{each}") for each in commits]
    others = Others()
    with tempfile.TemporaryDirectory() as name:
        sides = []
        for number, tree in enumerate((*trees, Path.cwd())):
            scratch = Path(name, str(number))
            scratch.mkdir()
            sides.append(Side(tree, scratch, arguments.evaluations))
        first, *labels = (*commits, "now")
        heads = [f"{first:>10}", *(f"{label:>10} {'ratio':>6}" for label in labels)]
        print(f"{'least, then median':40} {' '.join(heads + heads)}")
        for quantity in arguments.quantities or QUANTITIES:
            print_ratios(measured(QUANTITIES[quantity], sides, arguments.rounds))
    print(f"other programs kept {others.processors():.1f} of {os.cpu_count()} processors busy")


def measured(quantity: Quantity, sides: list[Side], rounds: int) -> list[list[Figures]]:
    """Return what was measured of each side, which take turns to be the first of a round."""
    found: list[list[Figures]] = [[] for _ in sides]
    n_warming = int(quantity.is_warmed)
    for number in range(n_warming + ceil(rounds / quantity.share)):
        turns = list(zip(sides, found, strict=True))
        for side, figures in turns[:: 1 if number % 2 else -1]:
            figures.append(quantity.measure(side, number))
    return [figures[n_warming:] for figures in found]


if __name__ == "__main__":
    main()
