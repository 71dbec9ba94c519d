"""Whether searches find more where the pool declares triggers: equal evaluations, with and without.

Run ``python -m benchmarks.triggers [FILE]`` from the project's folder; rows go to ``FILE`` as CSV,
by default ``benchmarks/results/triggers.csv``. Each algorithm searches the paper's mission with 909
evaluations and 20 seeds, in one mission seed: once as it is, once with the four triggers below.
"""

import csv
import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from statistics import median
from typing import TYPE_CHECKING

from mrsfi.evolving import ALGORITHMS
from mrsfi_runtime.causes.weakness import Known, Yardstick
from mrsfi_runtime.engine.flights import Engine
from mrsfi_runtime.engine.opening import open_engine
from mrsfi_runtime.generated_code import load_code
from mrsfi_runtime.model.faults import Event, FaultPool, Trigger
from mrsfi_runtime.model.mission import Mission, Outcome
from mrsfi_runtime.record.engine_settings import EngineSettings
from mrsfi_runtime.record.settings import CampaignSettings
from mrsfi_runtime.search.algorithms import begin_search
from mrsfi_runtime.search.fitness import Judge
from mrsfi_runtime.search.space import SearchSpace

if TYPE_CHECKING:
    from mrsfi_runtime.causes.cause_set import Column

FILE = Path("benchmarks/results/triggers.csv")
SEARCHES = ("paper", "guided", "cover")
SEEDS = range(1, 21)
N_EVALUATIONS = 909
COLUMNS = ("algorithm", "triggers", "seed", "best", "violated", "missed", "weaknesses", "triggered")
"""Best fitness; goals more violated in truth, and missed, than without faults; minimal sets of
faults that break a goal by a measure, which ``cover`` alone seeks; evaluations in which a fault
that waited was set off."""


def triggers(mission: Mission) -> tuple[Trigger, ...]:
    """Return the four: energy runs short, samples are complete, a robot arrives, a fault bites."""
    area = mission.goals[mission.goal_ids.index("g5")].area
    return (
        Trigger("low", Event.VIOLATED, ("g3",)),
        Trigger("full", Event.REACHED, ("g4",)),
        Trigger("arrived", Event.ENTERED, ("r3",), area),
        Trigger("struck", Event.EFFECT, ("f9",), delay=10),
    )


def rows() -> Iterator[tuple[object, ...]]:
    """Yield what each search found."""
    code = load_code(Path("generated/uuv_sampling"))
    declared = triggers(code.mission)
    for pool in (code.pool, replace(code.pool, triggers=declared)):
        with open_engine(EngineSettings("compiled"), replace(code, pool=pool), 1) as engine:
            for algorithm in SEARCHES:
                for seed in SEEDS:
                    settings = CampaignSettings(
                        algorithm=algorithm, seed=seed, evaluations=N_EVALUATIONS
                    )
                    found = searched(settings, code.mission, pool, engine)
                    yield (algorithm, len(pool.triggers), seed, *found)


def searched(
    settings: CampaignSettings, mission: Mission, pool: FaultPool, engine: Engine
) -> tuple[object, ...]:
    """Search, and return what was found."""
    fault_free = engine.evaluate(())
    yardstick = Yardstick.of(mission, fault_free)
    judge, search = (
        Judge(settings, mission),
        begin_search(SearchSpace.of(mission, pool), settings, ALGORITHMS),
    )
    best, n_set_off = 0.0, 0
    broken: set[Column] = set()
    while not search.is_finished:
        asked = search.ask()
        flown = [each for each in engine.evaluate_many(asked) if isinstance(each, Outcome)]
        for specification, outcome in zip(asked, flown, strict=True):
            told = zip(specification, outcome.applied, strict=True)
            n_set_off += any(timed.trigger and applied for timed, applied in told)
            broken |= yardstick.broken(outcome)
        scores = [judge.score(each)._replace(outcome=each) for each in flown]
        best = max(best, *(score.fitness for score in scores))
        search.tell(scores)
    known: Known | None = getattr(search, "known", None)
    n_sets = "" if known is None else sum(map(len, known.sets.values()))
    n_goals = [sum(column.kind == kind for column in broken) for kind in ("true", "missed")]
    return (f"{best:.1f}", *n_goals, n_sets, n_set_off)


def main(path: Path) -> None:
    """Write all rows, and print medians."""
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(COLUMNS)
        for row in rows():
            writer.writerow(row)
            file.flush()
    with path.open(encoding="utf-8") as file:
        found = [*csv.DictReader(file)]
    for algorithm in SEARCHES:
        for declared in ("0", "4"):
            some = [r for r in found if (r["algorithm"], r["triggers"]) == (algorithm, declared)]
            told = [f"{name} {median(float(r[name] or 0) for r in some):g}" for name in COLUMNS[3:]]
            sys.stdout.write(f"{algorithm}, {declared} triggers: medians: {', '.join(told)}\n")


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else FILE)
