"""Whether a search for one goal is helped by how near the goal came to being violated.

Run ``python -m benchmarks.nearest [MISSION ...] --out FILE.csv`` from the project's folder. For
each goal of a mission, the faults that truly break it alone are left out of the pool: all are flown
alone in 200 forms. In what is left, ``guided`` searches for the goal's true violations with the
fitness ``focused`` and with ``nearest``, and ``random`` searches beside them: as many evaluations,
the same seeds. Written is the evaluation at which the goal first broke, if it did.
"""

import argparse
import csv
import statistics
from collections import defaultdict
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from random import Random

from mrsfi.evolving import ALGORITHMS
from mrsfi_runtime.engine.compiled.engine import CompiledEngine
from mrsfi_runtime.generated_code import MissionCode, load_code
from mrsfi_runtime.model.faults import FaultPool
from mrsfi_runtime.model.mission import Outcome
from mrsfi_runtime.record.settings import CampaignSettings
from mrsfi_runtime.search.fitness import Judge
from mrsfi_runtime.search.space import SearchSpace, mutated, random_specification

FORMS = 200
SEARCHES = (("guided", "focused"), ("guided", "nearest"), ("random", "focused"))
COLUMNS = ("mission", "goal", "pool", "algorithm", "fitness", "seed", "evaluation")
Row = tuple[str, str, int, str, str, int, int | None]


def alone(code: MissionCode, engine: CompiledEngine) -> Mapping[int, set[str]]:
    """Return the faults that truly break each goal alone in some form, by the goal's place."""
    found: defaultdict[int, set[str]] = defaultdict(set)
    rng = Random(1)
    for fault in code.pool:
        space = SearchSpace.of(code.mission, FaultPool("alone", (fault,)))
        forms = [random_specification(space, 1, rng) for _ in range(FORMS)]
        forms = [mutated(space, each, rng, 1.0) for each in forms]
        for outcome in engine.evaluate_many(forms):
            if isinstance(outcome, Outcome):
                for place, n_violated in enumerate(outcome.true):
                    if n_violated:
                        found[place].add(fault.id)
    return found


def first_broken(code: MissionCode, settings: CampaignSettings, place: int) -> int | None:
    """Return the evaluation of a search, from 1, at which a goal first truly broke."""
    judge = Judge(settings, code.mission)
    search = ALGORITHMS[settings.algorithm](SearchSpace.of(code.mission, code.pool), settings)
    engine = CompiledEngine(code, settings.mission_seed)
    n_flown = 0
    while not search.is_finished:
        scores = []
        for outcome in engine.evaluate_many(search.ask()):
            n_flown += 1
            if not isinstance(outcome, Outcome):
                raise TypeError(outcome.traceback)
            if outcome.true[place]:
                engine.close()
                return n_flown
            scores.append(judge.score(outcome))
        search.tell(scores)
    engine.close()
    return None


def rows(name: str, n_seeds: int, n_evaluations: int) -> Iterator[Row]:
    """Yield what became of all searches on a mission."""
    code = load_code(Path("generated") / name)
    engine = CompiledEngine(code, 1)
    (fault_free,) = engine.evaluate_many([()])
    known = alone(code, engine)
    engine.close()
    for place, goal in enumerate(code.mission.goal_ids):
        left = tuple(fault for fault in code.pool if fault.id not in known[place])
        if not left or not isinstance(fault_free, Outcome) or fault_free.true[place]:
            continue
        part = replace(code, pool=FaultPool("left", left))
        for algorithm, fitness in SEARCHES:
            for seed in range(1, n_seeds + 1):
                settings = CampaignSettings(
                    algorithm=algorithm,
                    fitness=fitness,
                    violations="true",
                    goals=(goal,),
                    faults=min(20, len(left)),
                    seed=seed,
                    evaluations=n_evaluations,
                )
                found = first_broken(part, settings, place)
                yield name, goal, len(left), algorithm, fitness, seed, found


def summary(found: list[Row]) -> Iterator[str]:
    """Yield a line for each goal that any search broke, and how many none did."""
    by_goal: defaultdict[tuple[str, str, int], dict[str, list[float]]] = defaultdict(dict)
    for mission, goal, n_faults, algorithm, fitness, _, evaluation in found:
        first = float("inf") if evaluation is None else float(evaluation)
        by_goal[mission, goal, n_faults].setdefault(f"{algorithm} {fitness}", []).append(first)
    n_unbroken = 0
    for (mission, goal, n_faults), searches in by_goal.items():
        if all(first == float("inf") for each in searches.values() for first in each):
            n_unbroken += 1
            continue
        told = [
            f"{name}: {sum(first < float('inf') for first in each)} of {len(each)}, "
            f"median {statistics.median(each):g}"
            for name, each in searches.items()
        ]
        a, b = searches["guided nearest"], searches["guided focused"]
        wins = sum((x < y) + 0.5 * (x == y) for x in a for y in b) / (len(a) * len(b))
        yield f"{mission} {goal} ({n_faults} faults): {'; '.join(told)}; A12 {wins:.2f}"
    yield f"broken by no search: {n_unbroken} goals"


def main() -> None:
    """Search, write the rows, and print a line for each goal."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("missions", nargs="*", default=["uuv_sampling", "tight_margins"])
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--evaluations", type=int, default=909)
    parser.add_argument("--out", type=Path, required=True)
    arguments = parser.parse_args()
    found: list[Row] = []
    with arguments.out.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(COLUMNS)
        for name in arguments.missions:
            for row in rows(name, arguments.seeds, arguments.evaluations):
                found.append(row)
                writer.writerow(row)
    print("\n".join(summary(found)))


if __name__ == "__main__":
    main()
