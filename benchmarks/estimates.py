"""How many weaknesses campaigns estimate, beside those that brute force knows.

Run ``python -m benchmarks.estimates [MISSION ...]`` from the project's folder. Campaigns and brute
force are those of ``benchmarks.weaknesses``. A set is true if brute force knows it or if one of the
campaigns found it, unless a part of it is true. Estimates are printed for the sets that hold in all
five mission seeds, as brute force knows them, and for all sets that the campaigns found.
"""

import argparse
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from random import Random
from typing import Any

from benchmarks.weaknesses import MISSIONS, SEEDS, Brute, Known, Weaknesses, project_of, told_by
from benchmarks.weaknesses import weakness_of as named
from mrsfi_runtime.causes.missing import Total, estimate
from mrsfi_runtime.causes.weakness import MEASURES, Weakness
from mrsfi_runtime.generated_code import load_code

SAMPLES = (3, 6)


def is_firm(told: Mapping[str, Any]) -> bool:
    """Return whether a weakness was flown, and holds, in as many seeds as brute force flies."""
    return bool(told["seeds"]["held"] == told["seeds"]["of"] == len(SEEDS))


def minimal(sets: Iterable[Any]) -> Weaknesses:
    """Return the weaknesses of which no part is one."""
    every = frozenset(sets)
    return frozenset(
        each
        for each in every
        if not any(part.judged == each.judged and part.faults < each.faults for part in every)
    )


def cells(samples: Sequence[Sequence[Mapping[str, Any]]], known: Known) -> str:
    """Return what samples found, estimate together, and what is true, as cells of a table.

    The last cell says for how many goals, and for how many goals by a measure, the interval
    contains what is true.
    """
    sets = [frozenset(map(named, each)) for each in samples]
    found = minimal(frozenset[Any]().union(*sets))
    true = minimal(known.surely | found)
    total = Total.of([each & found for each in sets])
    listed = [[Weakness.from_json(each) for each in sample] for sample in samples]
    right = []
    for measures in ([MEASURES], [[each] for each in MEASURES]):
        judged = []
        for some in measures:
            for goal in sorted({each.judged.goal for each in true}):
                n_true = len(
                    {t.faults for t in true if t.judged.goal == goal and t.judged.measure in some}
                )
                _, _, low, high = estimate(listed, goal, some).total
                judged += [low <= n_true <= high] * (n_true > 0)
        right.append(f"{sum(judged)} of {len(judged)}")
    n_each = [len(each) for each in sets]
    return (
        f"{min(n_each)} to {max(n_each)} | {total.n_found} | {total.value:.0f} ({total.low} to "
        f"{total.high}) | {len(true)} | {' | '.join(right)}"
    )


def main() -> None:
    """Print a row for each mission, search, number of campaigns, and kind of sets."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("missions", nargs="*", metavar="MISSION", default=MISSIONS)
    for name in parser.parse_args().missions:
        with project_of(name) as (models, generated):
            known = Brute(load_code(Path(generated)), Random(77)).known()
            for algorithm, n, n_seeds in (("cover", 909, len(SEEDS)), ("paper", None, None)):
                runs = [
                    told_by(models, algorithm, seed, n, n_seeds)
                    for seed in range(1, max(SAMPLES) + 1)
                ]
                firm = [[each for each in run if is_firm(each)] for run in runs]
                for sets, some in (("firm", firm), ("all", runs)):
                    for n_runs in SAMPLES:
                        row = f"| {name} | {algorithm} | {sets} | {n_runs} | "
                        print(f"{row}{cells(some[:n_runs], known)} |", flush=True)


if __name__ == "__main__":
    main()
