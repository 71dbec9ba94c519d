"""How long missions take to load, validate, save, mend and generate: seconds, growth, memory.

Run as ``python -m benchmarks.models [LARGEST]``, where ``LARGEST`` is the greatest number of
robots; there are ten faults to a robot. To be mended is a copy in which every fault finishes before
it starts. Seconds are the processor's. Growth compares the seconds for one robot with those of the
line above: 1.0 is linear.
"""

import shutil
import sys
import tempfile
import time
import tracemalloc
from collections.abc import Callable
from pathlib import Path
from typing import Any

from benchmarks.fleets import write_fleet
from m2t.fixes import mend
from m2t.generate import plan
from m2t.load import inspect_folder, load_mission_folder
from m2t.saving import saved

SIZES = (10, 30, 100, 300, 1_000, 2_000)
FAULTS_PER_ROBOT = 10
DURATION = 100


def _write_broken(folder: Path, n_robots: int) -> None:
    """Write the mission with a defect in each of its faults."""
    write_fleet(folder, n_robots, DURATION, FAULTS_PER_ROBOT * n_robots)
    faults = folder / "faults.xmi"
    text = faults.read_text(encoding="ascii")
    broken = text.replace('" name="', '" start="9" finish="8" name="')
    faults.write_text(broken, encoding="ascii")


def _measured(work: Callable[[], Any]) -> tuple[float, Any]:
    """Return the processor's seconds, which other programs do not lengthen, and the result."""
    start = time.process_time()
    result = work()
    return time.process_time() - start, result


def _peak(work: Callable[[], Any]) -> float:
    """Return the peak of memory that Python objects took, in megabytes."""
    tracemalloc.start()
    work()
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    return peak / 1e6


def main() -> None:
    """Print one line per size."""
    largest = int(sys.argv[1]) if len(sys.argv) > 1 else max(SIZES)
    print(
        " robots  faults   load s  validate s   save s  defects   mend s  generate s  growth "
        " peak MB"
    )
    before = None
    with tempfile.TemporaryDirectory() as name:
        write_fleet(Path(name) / "warm", 1, DURATION, 1)
        load_mission_folder(Path(name) / "warm")
        for n_robots in (size for size in SIZES if size <= largest):
            folder = Path(name) / str(n_robots)
            write_fleet(folder, n_robots, DURATION, FAULTS_PER_ROBOT * n_robots)
            load, models = _measured(lambda folder=folder: load_mission_folder(folder))
            validate, found = _measured(lambda folder=folder: inspect_folder(folder).diagnostics)
            save, contents = _measured(lambda models=models: saved(models))
            _write_broken(Path(name) / "broken", n_robots)
            inspection = inspect_folder(Path(name) / "broken")
            mending, mended = _measured(lambda inspection=inspection: mend(inspection))
            generate, _ = _measured(lambda folder=folder: plan(folder, folder / "generated"))
            assert not found
            assert contents
            assert mended is not None
            each = (load + validate + save + mending + generate) / n_robots
            growth = "" if before is None else f"{each / before:.2f}"
            before = each
            n_defects = len(mended.fixed)
            del models, contents, inspection, mended
            shutil.rmtree(Path(name) / "broken")
            peak = _peak(lambda folder=folder: saved(load_mission_folder(folder)))
            print(
                f"{n_robots:7,} {n_robots * FAULTS_PER_ROBOT:7,} {load:8.2f} {validate:11.2f} "
                f"{save:8.2f} {n_defects:8,} {mending:8.2f} {generate:11.2f} {growth:>7} "
                f"{peak:8.1f}"
            )


if __name__ == "__main__":
    main()
