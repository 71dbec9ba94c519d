"""How long missions take to load, validate, save, mend and generate: seconds, growth, memory.

Run as ``python benchmarks/models.py [LARGEST]``, where ``LARGEST`` is the greatest number of
robots; there are ten faults to a robot. To be mended is a copy in which every fault finishes before
it starts. Seconds are the processor's. Growth compares the seconds for one robot with those of the
line above: 1.0 is linear.
"""

import shutil
import sys
import tempfile
import time
import tracemalloc
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from m2t.fixes import mend
from m2t.generate import plan
from m2t.load import inspect_folder, load_mission_folder
from m2t.saving import saved

SIZES = (10, 30, 100, 300, 1_000, 2_000)
FAULTS_PER_ROBOT = 10

_HEAD = (
    '<?xml version="1.0" encoding="ASCII"?>\n<{package}:{root} xmi:version="2.0" '
    'xmlns:xmi="http://www.omg.org/XMI" xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance" '
    'xmlns:{package}="http://mrsfi.org/{package}/1.0" {attributes}>\n'
)


def write_mission(folder: Path, n_robots: int) -> None:
    """Write a mission in which every robot keeps within the area and reports its speed."""
    folder.mkdir()
    (folder / "mission.xmi").write_text("".join(_mission(n_robots)), encoding="ascii")
    (folder / "faults.xmi").write_text("".join(_faults(n_robots)), encoding="ascii")


def _mission(n_robots: int) -> Iterator[str]:
    yield _HEAD.format(
        package="mission", root="Mission", attributes='name="benchmark" duration="100"'
    )
    yield '  <missionArea ID="area" radius="1000000.0"/>\n'
    for robot in range(n_robots):
        yield (
            f'  <robots ID="r{robot}" name="robot {robot}" speed="1.0">\n'
            f'    <position x="{robot * 10}.0"/>\n'
            f'    <sensors ID="s{robot}" name="GPS" type="GPS_POSITION" energyPerSample="1.0" '
            f'samplesPerSecond="1"/>\n'
            f'    <batteries ID="b{robot}" name="battery" totalEnergy="100.0"/>\n'
            "  </robots>\n"
        )
    members = " ".join(f"r{robot}" for robot in range(n_robots))
    yield f'  <servers ID="sv" name="server"/>\n  <goals ID="g" name="stay" members="{members}">\n'
    yield '    <task xsi:type="mission:StayWithinMissionArea"/>\n'
    for robot in range(n_robots):
        yield (
            f'    <messages ID="m{robot}" sender="r{robot}" receiver="sv">\n'
            '      <body name="SPEED" type="Int"/>\n    </messages>\n'
        )
    yield "  </goals>\n</mission:Mission>\n"


def _faults(n_robots: int) -> Iterator[str]:
    yield _HEAD.format(package="faults", root="FaultSpecification", attributes='ID="pool"')
    for fault in range(n_robots * FAULTS_PER_ROBOT):
        yield (
            f'  <faults ID="f{fault}" name="fault {fault}">\n    <zeroSpeed>\n'
            f'      <affectedMessage href="mission.xmi#m{fault % n_robots}"/>\n'
            "    </zeroSpeed>\n  </faults>\n"
        )
    yield "</faults:FaultSpecification>\n"


def _write_broken(folder: Path, n_robots: int) -> None:
    """Write the mission with a defect in each of its faults."""
    write_mission(folder, n_robots)
    faults = folder / "faults.xmi"
    text = faults.read_text(encoding="ascii")
    broken = text.replace('" name="fault ', '" start="9" finish="8" name="fault ')
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
        write_mission(Path(name) / "warm", 1)
        load_mission_folder(Path(name) / "warm")
        for n_robots in (size for size in SIZES if size <= largest):
            folder = Path(name) / str(n_robots)
            write_mission(folder, n_robots)
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
