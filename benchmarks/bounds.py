"""How often the bounds of what ``cover`` did not find hold, against fresh random specifications.

Run ``python -m benchmarks.bounds [MISSION ...]`` from the project's folder. Of each of some
searches, some bounds are taken; each claims to hold with a confidence of 95 %.
"""

import sys
from pathlib import Path
from random import Random

from mrsfi_runtime.causes.cover import Cover
from mrsfi_runtime.causes.weakness import Yardstick
from mrsfi_runtime.engine.settings import EngineSettings
from mrsfi_runtime.mission import MissionCode, load_code
from mrsfi_runtime.record.settings import CampaignSettings
from mrsfi_runtime.search.fitness import Score
from mrsfi_runtime.search.space import SearchSpace
from mrsfi_runtime.search.specifications import varied_specification

MISSIONS = ("uuv_sampling", "tight_margins", "tight_energy")
BOUNDED, N_BOUNDED, N_FRESH = range(11, 19), 9, 600
"""Seeds of searches, bounds that are looked at of each, and specifications drawn for each."""


def bounds_that_hold(code: MissionCode) -> tuple[int, int]:
    """Return how many bounds are at least what fresh specifications show, and of how many."""
    space, held = SearchSpace.of(code.mission, code.pool), []
    with EngineSettings("compiled").open(code, 1, 2) as engine:
        (fault_free,) = engine.evaluate_many([()])
        yardstick = Yardstick.of(code.mission, fault_free)
        for seed in BOUNDED:
            search, random = (
                Cover(space, CampaignSettings(evaluations=1500, seed=seed)),
                Random(seed),
            )
            while not search.is_finished:
                outcomes = engine.evaluate_many(search.ask())
                search.tell([Score(0.0, (), outcome) for outcome in outcomes])
            known = search.known
            for column in random.sample([*known.sets], N_BOUNDED):

                def is_allowed(faults: frozenset[str]) -> bool:
                    return not known.has_part_of(column, faults)  # noqa: B023 - called in the loop

                fresh = [
                    varied_specification(space, 20, random, is_allowed) for _ in range(N_FRESH)
                ]
                found = engine.evaluate_many(fresh)
                n_broken = sum(column in yardstick.broken(outcome) for outcome in found)
                if known.n_kept[column]:
                    held.append(known.bound(column) >= n_broken / N_FRESH)
    return sum(held), len(held)


def main() -> None:
    """Print a line for each mission."""
    for mission in sys.argv[1:] or MISSIONS:
        n_held, n = bounds_that_hold(load_code(Path("generated") / mission))
        print(f"{mission}: {n_held} of {n} bounds hold", flush=True)


if __name__ == "__main__":
    main()
