"""How fast the engines evaluate, side by side in one run.

Run ``python -m benchmarks.engines`` from the project's root after ``make install``. Every
engine evaluates the same random specifications of the paper's mission in turn, round after
round, so that whatever else runs on this machine slows all alike; the ratios are what counts.
"""

import argparse
import statistics
import time
from contextlib import ExitStack
from pathlib import Path

from benchmarks.measuring import drawn, seconds
from mrsfi.engines import evaluator
from mrsfi_runtime.engine.cluster import ClusterPool
from mrsfi_runtime.engine.flights import Evaluator
from mrsfi_runtime.generated_code import load_code
from mrsfi_runtime.record.engine_settings import COMPILED, LOCAL, REFERENCE, EngineSettings, Workers

MISSION = Path("generated/uuv_sampling")
ENGINES = (
    ("reference", REFERENCE, 1, False, 4),
    ("reference, 2 processes", REFERENCE, 2, False, 8),
    ("reference, 2 of dask", REFERENCE, 2, True, 8),
    ("compiled", COMPILED, 1, False, 200),
    ("compiled, 2 threads", COMPILED, 2, False, 400),
    ("compiled, 2 of dask", COMPILED, 2, True, 2000),
)
"""Label, engine, workers, whether a local cluster has them, and specifications of a round."""


def opened(stack: ExitStack, name: str, workers: int, *, on_dask: bool) -> Evaluator:
    """Return what evaluates, until the stack is closed."""
    settings = EngineSettings(name)
    if not on_dask:
        evaluating = evaluator(load_code(MISSION), 1, settings, Workers(workers))
        return stack.enter_context(evaluating)
    return stack.enter_context(ClusterPool(LOCAL, workers, load_code(MISSION), 1, settings))


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rounds", type=int, default=7, help="at least 2")
    parser.add_argument("--faults", type=int, default=20, help="timed faults of a specification")
    arguments = parser.parse_args()
    if arguments.rounds < 2:
        parser.error(f"--rounds: found {arguments.rounds}; expected at least 2, for quartiles")
    specifications = drawn(load_code(MISSION), max(n for *_, n in ENGINES), arguments.faults)
    rates: dict[str, list[float]] = {label: [] for label, *_ in ENGINES}
    with ExitStack() as stack:
        pools = []
        for label, name, workers, on_dask, n in ENGINES:
            opening = time.perf_counter()
            pool = opened(stack, name, workers, on_dask=on_dask)
            list(pool.evaluate_many(specifications[:n]))
            taken = time.perf_counter() - opening
            print(f"{label}: ready, with a first round, after {taken:.2f} s")
            pools.append(pool)
        for _ in range(arguments.rounds):
            for pool, (label, *_, n) in zip(pools, ENGINES, strict=True):
                chosen = specifications[:n]
                rates[label].append(n / seconds(lambda p=pool, s=chosen: list(p.evaluate_many(s))))
    base = statistics.median(rates[ENGINES[0][0]])
    print(f"\n{'engine':24} {'evaluations/s':>14} {'quartiles':>19} {'ms each':>9} {'ratio':>7}")
    for label, found in rates.items():
        low, middle, high = statistics.quantiles(found, n=4)
        quartiles = f"{low:,.0f} to {high:,.0f}"
        row = f"{label:24} {middle:14,.0f} {quartiles:>19} {1000 / middle:9.3f}"
        print(f"{row} {middle / base:7.1f}")


if __name__ == "__main__":
    main()
