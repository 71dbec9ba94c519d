"""How fast the engines evaluate, side by side in one run.

Run ``python -m benchmarks.engines`` from the project's root after ``make install``. Every
engine evaluates the same random specifications of the paper's mission in turn, round after
round, so that whatever else runs on this machine slows all alike; the ratios are what counts.
"""

import argparse
import statistics
import time
from collections.abc import Callable
from pathlib import Path
from random import Random

from mrsfi_runtime.engine.pools import WorkerPool
from mrsfi_runtime.engine.settings import COMPILED, REFERENCE, EngineSettings
from mrsfi_runtime.mission import load_code
from mrsfi_runtime.model.faults import Specification
from mrsfi_runtime.search.space import SearchSpace
from mrsfi_runtime.search.specifications import random_specification

MISSION = Path("generated/uuv_sampling")
ENGINES = (
    ("reference", REFERENCE, 1, 4),
    ("reference, 2 processes", REFERENCE, 2, 8),
    ("compiled", COMPILED, 1, 200),
    ("compiled, 2 threads", COMPILED, 2, 400),
)
"""Label, engine, workers, and specifications of a round."""


def seconds(function: Callable[[], object]) -> float:
    """Return how long a call takes."""
    start = time.perf_counter()
    function()
    return time.perf_counter() - start


def drawn(n: int, n_faults: int) -> list[Specification]:
    """Return random specifications of the mission's pool."""
    code = load_code(MISSION)
    space = SearchSpace.of(code.mission, code.pool)
    return [random_specification(space, n_faults, Random(seed)) for seed in range(n)]


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--faults", type=int, default=20, help="timed faults of a specification")
    arguments = parser.parse_args()
    specifications = drawn(max(n for *_, n in ENGINES), arguments.faults)
    pools = []
    for label, name, workers, n in ENGINES:
        opening = time.perf_counter()
        pool = WorkerPool(MISSION, 1, workers, EngineSettings(name))
        list(pool.evaluate_many(specifications[:n]))
        print(f"{label}: ready, with a first round, after {time.perf_counter() - opening:.2f} s")
        pools.append(pool)
    rates: dict[str, list[float]] = {label: [] for label, *_ in ENGINES}
    for _ in range(arguments.rounds):
        for pool, (label, _, _, n) in zip(pools, ENGINES, strict=True):
            chosen = specifications[:n]
            rates[label].append(n / seconds(lambda p=pool, s=chosen: list(p.evaluate_many(s))))
    for pool in pools:
        pool.close()
    base = statistics.median(rates[ENGINES[0][0]])
    print(f"\n{'engine':24} {'evaluations/s':>14} {'quartiles':>19} {'ms each':>9} {'ratio':>7}")
    for label, found in rates.items():
        low, middle, high = statistics.quantiles(found, n=4)
        quartiles = f"{low:,.0f} to {high:,.0f}"
        row = f"{label:24} {middle:14,.0f} {quartiles:>19} {1000 / middle:9.3f}"
        print(f"{row} {middle / base:7.1f}")


if __name__ == "__main__":
    main()
