"""How evaluation grows with robots, faults, ticks and population: seconds, exponent, memory.

Run ``python -m benchmarks.growth`` from the project's root after ``make install``, or with
``--quick`` for small sizes, or with names of tables. Every size is measured in a process of its
own, on the compiled engine with one thread; the processor's time counts, that of the quickest of
some repetitions, without compilation. An exponent of 1 is linear. Every number of robots is
compiled anew, which takes most of the time.

Ends with 1 if an aim is missed.
"""

import argparse
import json
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from types import MappingProxyType

from benchmarks.fleets import fleet
from benchmarks.measuring import MEBI, Aims, drawn, exponent, run
from mrsfi_runtime.engine.compiled.engine import CompiledEngine
from mrsfi_runtime.generated_code import MissionCode, load_code
from mrsfi_runtime.record.engine_settings import Manifest
from mrsfi_runtime.record.settings import CampaignSettings
from mrsfi_runtime.record.store import CampaignStore
from mrsfi_runtime.search.run import run_campaign

MISSION = Path("generated") / "uuv_sampling"
N_FAULTS, N_TICKS = 20, 1_000
LEAST_SECONDS = 0.5
"""Repetitions go on for so long."""
LINEAR = 1.1
"""Exponent up to which growth counts as linear."""


@dataclass(frozen=True)
class Growth:
    """A table: what grows, its sizes, the unit of its figures, and from where it is fitted."""

    cost: Callable[[int], float]  # milliseconds of one evaluation, or of a whole search
    sizes: tuple[int, ...]
    quick: tuple[int, ...]
    unit: str
    first_fitted: int = 0
    is_linear: bool = True  # as an aim
    most: float | None = None  # milliseconds of the greatest size


def evaluation_ms(code: MissionCode, n_faults: int, n_specifications: int) -> float:
    """Return the least milliseconds of one evaluation among several rounds."""
    specifications = drawn(code, n_specifications, n_faults)
    with CompiledEngine(code, 1) as engine:
        list(engine.evaluate_many(specifications[:2]))  # compiles, and compares with the reference
        return repeated(lambda: list(engine.evaluate_many(specifications))) / n_specifications


def repeated(work: Callable[[], object]) -> float:
    """Return the least milliseconds of the processor that some work takes."""
    least, end = float("inf"), time.perf_counter() + LEAST_SECONDS
    while least == float("inf") or time.perf_counter() < end:
        start = time.process_time()
        work()
        least = min(least, time.process_time() - start)
    return 1000 * least


def of_robots(n_robots: int) -> float:
    """Return the milliseconds of an evaluation of a fleet."""
    with tempfile.TemporaryDirectory() as name:
        code = fleet(Path(name), n_robots, N_TICKS)
        return evaluation_ms(code, N_FAULTS, max(2, 300 // n_robots))


def of_faults(n_faults: int) -> float:
    """Return the milliseconds of an evaluation of the paper's mission with more faults."""
    return evaluation_ms(load_code(MISSION), n_faults, 50)


def of_ticks(n_ticks: int) -> float:
    """Return the milliseconds of an evaluation of the paper's mission when it lasts longer."""
    code = load_code(MISSION)
    longer = replace(code, mission=replace(code.mission, duration=n_ticks))
    return evaluation_ms(longer, N_FAULTS, max(2, 50_000 // n_ticks))


def of_population(n_individuals: int) -> float:
    """Return the milliseconds of a search of two generations with its record."""
    code = load_code(MISSION)
    settings = CampaignSettings(population=n_individuals, generations=1)
    with CompiledEngine(code, settings.mission_seed) as engine:
        list(engine.evaluate_many(drawn(code, 2)))

        def searched() -> None:
            with (
                tempfile.TemporaryDirectory() as name,
                CampaignStore.create(Path(name) / "run", settings, Manifest()) as store,
            ):
                run_campaign(settings, code.mission, code.pool, engine.evaluate_many, store)

        return repeated(searched)


TABLES = MappingProxyType(
    {
        "robots": Growth(
            of_robots, (3, 10, 30, 100, 300, 1_000), (3, 30, 100), "ms/evaluation", 100, most=200.0
        ),
        "faults": Growth(
            of_faults, (20, 50, 100, 200, 500), (20, 100), "ms/evaluation", is_linear=False
        ),
        "ticks": Growth(
            of_ticks, (1_000, 3_000, 10_000, 30_000, 100_000), (1_000, 10_000), "ms/evaluation"
        ),
        "population": Growth(
            of_population, (20, 100, 1_000, 10_000), (20, 200), "ms/2 generations"
        ),
    }
)
"""What grows."""


def print_growth(name: str, sizes: Sequence[int], aims: Aims) -> None:
    """Print the table of one kind of growth."""
    growth = TABLES[name]
    print(f"\n{name:>10} {growth.unit:>18} {'us of each':>11} {'growth':>7} {'MiB':>6}", flush=True)
    costs: list[float] = []
    for size in sizes:
        found = run("benchmarks.growth", "--one", str(size), name)
        costs.append(found.found())
        each = 1000 * costs[-1] / size
        step = f"{exponent(sizes[: len(costs)][-2:], costs[-2:]):.2f}" if costs[1:] else ""
        peak = found.peak / MEBI
        print(f"{size:10,} {costs[-1]:18,.3f} {each:11,.2f} {step:>7} {peak:6.0f}", flush=True)
    fitted = [(s, c) for s, c in zip(sizes, costs, strict=True) if s >= growth.first_fitted]
    if fitted[1:]:
        slope = exponent(*zip(*fitted, strict=True))
        what = f"{name}: exponent from {fitted[0][0]:,} on"
        if growth.is_linear:
            aims.below(what, slope, LINEAR, "")
        else:
            print(f"{what:58} {slope:8.2f}")
    if growth.most is not None and sizes[-1] == growth.sizes[-1]:
        aims.below(f"{name}: {sizes[-1]:,}", costs[-1], growth.most, "ms")


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("tables", nargs="*", metavar="TABLE", help=f"of {', '.join(TABLES)}")
    parser.add_argument("--quick", action="store_true", help="small sizes only")
    parser.add_argument("--one", type=int, help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    unknown = [name for name in arguments.tables if name not in TABLES]
    if unknown:
        parser.error(f"found table '{unknown[0]}'; expected some of: {', '.join(TABLES)}")
    return arguments


def main() -> int:
    """Print all tables; return 1 if an aim is missed."""
    arguments = _arguments()
    if arguments.one:
        print(json.dumps(TABLES[arguments.tables[0]].cost(arguments.one)))
        return 0
    aims = Aims()
    for name in arguments.tables or TABLES:
        growth = TABLES[name]
        print_growth(name, growth.quick if arguments.quick else growth.sizes, aims)
    return aims.exit_code()


if __name__ == "__main__":
    sys.exit(main())
