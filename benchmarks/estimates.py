"""How many weaknesses campaigns estimate, and how likely goals are to break, beside the truth.

Run ``python -m benchmarks.estimates [MISSION ...]`` from the project's folder. Campaigns and brute
force are those of ``benchmarks.weaknesses``. A set is true if brute force knows it or if one of the
campaigns found it, unless a part of it is true. Estimates are printed for the sets that hold in all
five mission seeds, as brute force knows them, and for all sets that the campaigns found.

Risks stand beside ``N_MISSIONS`` missions in which every fault occurs with the same likelihood, in
a variant that ``cover`` could draw, unless a conflicting fault leaves it no window.
"""

import argparse
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from itertools import chain
from random import Random
from typing import Any

from benchmarks.weaknesses import MISSIONS, SEEDS, Brute, Known, Weaknesses, project_of, told_by
from benchmarks.weaknesses import weakness_of as named
from mrsfi_runtime.causes.consequences import Total, estimate, risk
from mrsfi_runtime.causes.mildest import goal_weaknesses
from mrsfi_runtime.causes.weakness import MEASURES, Weakness, yardstick_of
from mrsfi_runtime.engine.opening import open_engine
from mrsfi_runtime.generated_code import MissionCode, load_code
from mrsfi_runtime.model.faults import FaultPool, Specification, TimedFault
from mrsfi_runtime.record.engine_settings import EngineSettings
from mrsfi_runtime.search.space import SearchSpace, varied_fault

SAMPLES = (3, 6)
LIKELIHOODS = (0.02, 0.1)
N_MISSIONS = 20_000


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


def frequencies(code: MissionCode, likelihood: float) -> dict[str, float]:
    """Return the share of missions with random faults that truly break each goal."""
    space, random = SearchSpace.of(code.mission, code.pool), Random(5)
    drawn: list[Specification] = []
    for _ in range(N_MISSIONS):
        placed: list[TimedFault] = []
        for fault in random.sample([*space.candidates], len(space.candidates)):
            if random.random() < likelihood and (free := space.free_windows(fault, placed)):
                placed.append(varied_fault(space, fault, free, random))
        drawn.append(space.ordered(placed))
    engine, flown = open_engine(EngineSettings("compiled"), code, 1, 2), [*dict.fromkeys(drawn)]
    (fault_free,) = engine.evaluate_many([()], 1)
    yardstick = yardstick_of(code.mission, fault_free, 1)
    broken = map(yardstick.broken, engine.evaluate_many(flown, 1))
    truly = {
        each: {column.goal for column in columns if column.kind != MEASURES[0]}
        for each, columns in zip(flown, broken, strict=True)
    }
    n_broken = Counter(chain.from_iterable(map(truly.__getitem__, drawn)))
    return {goal: n_broken[goal] / N_MISSIONS for goal in code.mission.goal_ids}


def risk_cells(
    code: MissionCode,
    likelihood: float,
    frequency: Mapping[str, float],
    samples: Sequence[Sequence[Mapping[str, Any]]],
) -> str:
    """Return the risks by one campaign and by several, as parts of the frequency of each goal.

    The last cell says for how many goals both values enclose the frequency. Goals that break in
    fewer than 0.1 % of missions are left out.
    """
    pool = FaultPool("pool", tuple(replace(each, likelihood=likelihood) for each in code.pool))
    ways = [goal_weaknesses(map(Weakness.from_json, each)) for each in samples]
    rows = [
        (alone.lower / often, both.lower / often, (both.upper or 0.0) / often)
        for goal, often in frequency.items()
        if often >= 0.001
        and (alone := risk(pool, goal, ways[:1]))
        and (both := risk(pool, goal, ways))
    ]
    n_right = sum(low <= 1.0 <= high for _, low, high in rows)
    parts = (f"{min(each):.2f} to {max(each):.2f}" for each in zip(*rows, strict=True))
    return f"{' | '.join(parts)} | {n_right} of {len(rows)}"


def main() -> None:
    """Print a row for each mission, search, number of campaigns, and kind of sets; then risks."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("missions", nargs="*", metavar="MISSION", default=(*MISSIONS, "undersea"))
    for name in parser.parse_args().missions:
        with project_of(name) as (models, generated):
            code = load_code(generated)
            known = Brute(code, Random(77)).known()
            frequency = {each: frequencies(code, each) for each in LIKELIHOODS}
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
                for each, often in frequency.items():
                    row = f"| {name} | {algorithm} | {each} | "
                    found = risk_cells(code, each, often, runs[: SAMPLES[0]])
                    print(f"{row}{found} |", flush=True)


if __name__ == "__main__":
    main()
