"""The paper's whole experiment from process start, its search alone, and what is not evaluation.

Run ``python -m benchmarks.experiment`` from the project's root after ``make install``, or with
``--quick`` for one round. Cold runs have an empty cache of compiled code, cached ones find it.
Case A and B take turns, and of each figure the run that others disturbed least counts.

Ends with 1 if an aim is missed. The aims are those of two free processors; how much of them
other programs took is printed last.
"""

import argparse
import json
import os
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from pathlib import Path

from benchmarks.measuring import MEBI, Aims, Others, Run, run
from mrsfi_runtime.engine.flights import Evaluated
from mrsfi_runtime.engine.pools import WorkerPool
from mrsfi_runtime.engine.settings import COMPILED, EngineSettings
from mrsfi_runtime.mission import load_code
from mrsfi_runtime.model.faults import Specification
from mrsfi_runtime.record.campaign import CampaignStore
from mrsfi_runtime.record.manifest import Manifest
from mrsfi_runtime.record.settings import CampaignSettings
from mrsfi_runtime.search.campaign import run_campaign

MISSION = "uuv_sampling"
CASES = ("a", "b")
COLD, CACHED, SEARCH = 20.0, 4.0, 1.0
"""Seconds that the experiment, cold and cached, and its search alone are to stay below."""
OUTSIDE = 30.0
"""Per cent of the search that is to be spent outside evaluation, at most."""


class TimedPool:
    """Evaluates, and adds up how long that takes."""

    def __init__(self, pool: WorkerPool) -> None:
        self._pool = pool
        self.seconds = self.processor = 0.0

    def evaluate_many(self, specifications: Sequence[Specification]) -> Iterator[Evaluated]:
        """Evaluate specifications; the time in between belongs to whoever takes the results."""
        results = self._pool.evaluate_many(specifications)
        while True:
            start = time.perf_counter(), time.process_time()
            result = next(results, None)
            self.seconds += time.perf_counter() - start[0]
            self.processor += time.process_time() - start[1]
            if result is None:
                return
            yield result


def search(case: str, n_workers: int) -> dict[str, float]:
    """Return what the search of a case takes in this process, compiled before it begins."""
    settings = CampaignSettings.load(Path("models") / MISSION / f"case_{case}.toml")
    code = load_code(Path("generated") / MISSION)
    with (
        tempfile.TemporaryDirectory() as name,
        CampaignStore.create(Path(name) / "run", settings, Manifest()) as store,
        WorkerPool(code, settings.mission_seed, n_workers, EngineSettings(COMPILED)) as workers,
    ):
        pool = TimedPool(workers)
        start = time.perf_counter(), time.process_time()
        run_campaign(settings, code.mission, code.pool, pool.evaluate_many, store)
        return {
            "seconds": time.perf_counter() - start[0],
            "processor": time.process_time() - start[1],
            "evaluation": pool.seconds,
            "evaluation_processor": pool.processor,
            "n_evaluations": store.n_evaluations,
        }


def experiment(case: str, cache: Path) -> Run:
    """Run ``mrsfi evolve`` from process start to its report, which explains nothing."""
    with tempfile.TemporaryDirectory() as name:
        words = ("mrsfi_runtime.cli.main", "evolve", MISSION, "--case", case, "--no-explain")
        return run(*words, "--out", f"{name}/run", environment={"MRSFI_CACHE": str(cache)})


def searched(case: str, n_workers: int, cache: Path) -> dict[str, float]:
    """Return what a search takes in a process of its own, and its peak memory."""
    words = ("benchmarks.experiment", "--search", case, "--workers", str(n_workers))
    found = run(*words, environment={"MRSFI_CACHE": str(cache)})
    return {**found.found(), "peak": found.peak}


def print_experiments(runs: dict[tuple[str, str], list[Run]], aims: Aims) -> None:
    """Print how long the experiments took."""
    print("\nmrsfi evolve, from process start to the report")
    print(f"{'':16} {'seconds':>8} {'processor':>10} {'MiB':>6}")
    for (cache, case), found in runs.items():
        best = min(found, key=lambda each: each.seconds)
        label = f"case {case}, {cache}"
        print(f"{label:16} {best.seconds:8.2f} {best.processor:10.2f} {best.peak / MEBI:6.0f}")
    for (cache, case), found in runs.items():
        limit = COLD if cache == "cold" else CACHED
        aims.below(f"case {case}, {cache}", min(each.seconds for each in found), limit, "s")


def print_searches(runs: dict[tuple[str, int], list[dict[str, float]]], aims: Aims) -> None:
    """Print how long the searches took, and what of it was not evaluation."""
    print("\nthe search alone, compiled before it begins")
    print(f"{'':20} {'seconds':>8} {'processor':>10} {'outside':>8} {'evaluations':>12} {'MiB':>6}")
    for (case, n_workers), found in runs.items():
        best = min(found, key=lambda each: each["seconds"])
        label = f"case {case}, {n_workers} thread{'s'[: n_workers != 1]}"
        print(
            f"{label:20} {best['seconds']:8.2f} {best['processor']:10.2f} {_outside(best):7.0f}% "
            f"{best['n_evaluations']:12,.0f} {best['peak'] / MEBI:6.0f}"
        )
    for case in CASES:
        seconds = [
            each["seconds"] for (of, _), found in runs.items() if of == case for each in found
        ]
        if seconds:
            aims.below(f"search of case {case}", min(seconds), SEARCH, "s")
            share = min(_outside(each) for each in runs[case, 1])
            aims.below(f"case {case}: outside evaluation, population 20", share, OUTSIDE, "%")


def _outside(search: dict[str, float]) -> float:
    """Return the processor's share of a search that was not evaluation, in per cent."""
    return 100 * (1 - search["evaluation_processor"] / search["processor"])


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--quick", action="store_true", help="one round")
    parser.add_argument("--search", choices=CASES, help=argparse.SUPPRESS)
    parser.add_argument("--workers", type=int, default=1, help=argparse.SUPPRESS)
    return parser.parse_args()


def main() -> int:
    """Print all figures; return 1 if an aim is missed."""
    arguments = _arguments()
    if arguments.search:
        print(json.dumps(search(arguments.search, arguments.workers)))
        return 0
    others = Others()
    experiments: dict[tuple[str, str], list[Run]] = {}
    searches: dict[tuple[str, int], list[dict[str, float]]] = {}
    with tempfile.TemporaryDirectory() as name:
        for case in CASES:  # each compiles anew; the second leaves what the cached runs find
            cache = Path(name) / case
            experiments["cold", case] = [experiment(case, cache)]
        for _ in range(1 if arguments.quick else 5):
            for case in CASES:
                experiments.setdefault(("cached", case), []).append(experiment(case, cache))
                for n_workers in (1, 2):
                    found = searched(case, n_workers, cache)
                    searches.setdefault((case, n_workers), []).append(found)
    aims = Aims()
    print_experiments(experiments, aims)
    print_searches(searches, aims)
    print(f"other programs kept {others.processors():.1f} of {os.cpu_count()} processors busy")
    return aims.exit_code()


if __name__ == "__main__":
    sys.exit(main())
