"""Whether the bounds and shares that campaigns print hold for fresh flights.

Run ``python -m benchmarks.claims bounds|until|shares [MISSION ...]`` from the project's folder.

- ``bounds``: ``cover`` ends after 600 evaluations. A bound of a goal and a measure holds if at most
  this share of 1,000 fresh random specifications, without its known sets, breaks the goal.
- ``until``: ``cover`` ends when all bounds are at most 0.1. A campaign is wrong if more than that
  share of 2,000 such specifications breaks any goal by any measure.
- ``shares``: each share of one fault stands beside the share of 200 fresh variants.
"""

import argparse
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from random import Random

from benchmarks.weaknesses import project_of
from mrsfi_runtime.causes.cause_set import Column
from mrsfi_runtime.causes.harvest import Cover
from mrsfi_runtime.causes.weakness import Known, Yardstick
from mrsfi_runtime.engine.opening import open_engine
from mrsfi_runtime.generated_code import load_code
from mrsfi_runtime.model.faults import Specification
from mrsfi_runtime.record.engine_settings import EngineSettings
from mrsfi_runtime.record.settings import CampaignSettings
from mrsfi_runtime.search.fitness import Score
from mrsfi_runtime.search.space import SearchSpace, varied_fault, varied_specification

MISSIONS = ("teams", "few", "uuv_sampling", "tight_energy")


class Bench:
    """A mission, its search space, and its compiled engine, in mission seed 1."""

    def __init__(self, generated: Path) -> None:
        code = load_code(generated)
        self.space = SearchSpace.of(code.mission, code.pool)
        self._many = open_engine(EngineSettings("compiled"), code, 1, 2).evaluate_many
        (fault_free,) = self._many([()], 1)
        self._yardstick = Yardstick.of(code.mission, fault_free)

    def searched(self, **settings: object) -> Known:
        """Search by ``cover`` to the end, and return what it knows."""
        search = Cover(self.space, CampaignSettings(algorithm="cover", **settings))
        while not search.is_finished:
            flown = self._many(search.ask(), 1)
            search.tell([Score(0.0, (), outcome) for outcome in flown])
        return search.known

    def share(self, column: Column, drawn: Sequence[Specification]) -> float:
        """Return the share of specifications that breaks a column."""
        return sum(column in self._yardstick.broken(o) for o in self._many(drawn, 1)) / len(drawn)

    def fresh(self, known: Known, column: Column, n: int, rng: Random) -> list[Specification]:
        """Draw random specifications that contain no known set of a column."""

        def is_unknown(faults: frozenset[str]) -> bool:
            return not known.has_part_of(column, faults)

        most = min(20, len(self.space.candidates))
        return [varied_specification(self.space, most, rng, is_unknown) for _ in range(n)]


def bounds(bench: Bench) -> Iterator[bool]:
    """Yield for a hundred bounds whether each holds."""
    n, seed = 0, 0
    while n < 100:
        seed += 1
        known, rng = bench.searched(evaluations=600, seed=seed), Random(1000 + seed)
        for column in rng.sample([*known.sets], min(5, len(known.sets))):
            if known.bound(column) < 1.0:
                n += 1
                drawn = bench.fresh(known, column, 1000, rng)
                yield bench.share(column, drawn) <= known.bound(column)


def until(bench: Bench) -> Iterator[bool]:
    """Yield for fifty campaigns whether all their bounds of 0.1 hold."""
    for seed in range(1, 51):
        known = bench.searched(evaluations=100_000, until=0.1, seed=seed, faults=20)
        rng = Random(2000 + seed)

        def exceeds(column: Column, n: int, most: float, known=known, rng=rng) -> bool:
            return bench.share(column, bench.fresh(known, column, n, rng)) > most

        yield not any(exceeds(c, 300, 0.05) and exceeds(c, 2000, 0.1) for c in known.sets)


def shares(bench: Bench) -> Iterator[bool]:
    """Yield for the shares of three campaigns whether a fresh one is in their intervals."""
    whole = [(0, bench.space.duration - 1)]
    for seed in (1, 2, 3):
        known, rng = bench.searched(evaluations=909, seed=seed), Random(3000 + seed)
        for each in known.weaknesses():
            if each.weighted:
                (fault,) = each.faults
                drawn = [(varied_fault(bench.space, fault, whole, rng),) for _ in range(200)]
                yield each.weighted.low <= bench.share(each.column, drawn) <= each.weighted.high


CLAIMS: dict[str, Callable[[Bench], Iterator[bool]]] = {
    "bounds": bounds,
    "until": until,
    "shares": shares,
}


def main() -> None:
    """Print for each mission how many claims hold."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("claim", choices=CLAIMS)
    parser.add_argument("missions", nargs="*", metavar="MISSION", default=MISSIONS)
    arguments = parser.parse_args()
    for name in arguments.missions:
        with project_of(name) as (_, generated):
            held = [*CLAIMS[arguments.claim](Bench(generated))]
            print(f"{name}: {sum(held)} of {len(held)} {arguments.claim} hold", flush=True)


if __name__ == "__main__":
    main()
