"""Print the share of crossovers that exchange something, and how many faults change sides.

Run ``python benchmarks/crossover.py`` from the project's root after ``make install``. The
pairs are random specifications of the paper's pool, cut to its first faults where said.
"""

from collections import Counter
from dataclasses import replace
from pathlib import Path
from random import Random

from mrsfi_runtime.generated_code import MissionCode, load_code
from mrsfi_runtime.model.faults import FaultPool
from mrsfi_runtime.search.space import SearchSpace
from mrsfi_runtime.search.specifications import random_specification
from mrsfi_runtime.search.variation import crossed

N_CALLS = 1_000
N_FAULTS = 20
DURATIONS = (1, 10, 100, 1_000, 10_000)
POOL_SIZES = (1, 3, 10, 30)


def measure(code: MissionCode, duration: int, n_pool: int) -> tuple[float, float]:
    """Return the share of calls that exchange something, and the mean number of faults moved."""
    pool = FaultPool("cut", code.pool.faults[:n_pool])
    space = SearchSpace.of(replace(code.mission, duration=duration), pool)
    rng = Random(1)
    n_exchanging = n_moved = 0
    for _ in range(N_CALLS):
        first = random_specification(space, N_FAULTS, rng)
        second = random_specification(space, N_FAULTS, rng)
        child, _ = crossed(space, first, second, rng)
        moved = (Counter(first) - Counter(child)).total()
        n_exchanging += moved > 0
        n_moved += moved
    return n_exchanging / N_CALLS, n_moved / N_CALLS


def main() -> None:
    """Print one row for each duration and pool."""
    code = load_code(Path("generated") / "uuv_sampling")
    print(f"{N_CALLS} crossovers of two random specifications of up to {N_FAULTS} faults")
    print("duration   pool   exchange something   faults that change sides, mean")
    for duration in DURATIONS:
        for n_pool in POOL_SIZES:
            share, moved = measure(code, duration, n_pool)
            print(f"{duration:8}   {n_pool:4}   {share:18.1%}   {moved:30.1f}")


if __name__ == "__main__":
    main()
