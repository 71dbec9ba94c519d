"""How often the bounds of what ``cover`` did not find hold, against fresh random specifications.

Run ``python -m benchmarks.bounds [MISSION ...]`` from the project's folder. Of each of some
searches, some bounds are taken; each claims to hold with a confidence of 95 %. What is drawn for
a bound depends on the sets that are known to break its column, so bounds with the same sets share
what is drawn.
"""

import sys
from collections import Counter, defaultdict
from collections.abc import Iterator
from pathlib import Path
from random import Random
from typing import NamedTuple, TypeAlias

from mrsfi_runtime.causes.counts import Column
from mrsfi_runtime.causes.cover import Cover
from mrsfi_runtime.causes.weakness import FaultSet, Yardstick
from mrsfi_runtime.engine.flights import Engine
from mrsfi_runtime.engine.settings import EngineSettings
from mrsfi_runtime.generated_code import MissionCode, load_code
from mrsfi_runtime.model.outcome import Outcome
from mrsfi_runtime.record.settings import CampaignSettings
from mrsfi_runtime.search.fitness import Score
from mrsfi_runtime.search.space import SearchSpace
from mrsfi_runtime.search.specifications import varied_specification

MISSIONS = ("uuv_sampling", "tight_margins", "tight_energy")
BOUNDED, N_BOUNDED, N_FRESH = range(11, 19), 9, 20_000
"""Seeds of searches, bounds that are looked at of each, and specifications drawn for each."""

_BATCH = 1_000

Excluded: TypeAlias = frozenset[FaultSet]
"""Sets of which a specification has none."""


class Bound(NamedTuple):
    """How often specifications without some sets break a column, at most."""

    column: Column
    chance: float


class Shown(NamedTuple):
    """A bound, and how many of the fresh specifications break its column."""

    bound: Bound
    n_broken: int

    @property
    def is_held(self) -> bool:
        """Whether the bound is at least what fresh specifications show."""
        return self.bound.chance >= self.n_broken / N_FRESH


def shown(code: MissionCode) -> Iterator[list[Shown]]:
    """Yield some bounds with the same sets of each, and what fresh specifications show of them."""
    space = SearchSpace.of(code.mission, code.pool)
    with EngineSettings("compiled").open(code, 1, 2) as engine:
        (fault_free,) = engine.evaluate_many([()])
        yardstick = Yardstick.of(code.mission, _flown(fault_free))
        taken: dict[Excluded, list[Bound]] = defaultdict(list)
        for seed in BOUNDED:
            for excluded, bound in _bounds(space, engine, seed):
                taken[excluded].append(bound)
        for number, (excluded, bounds) in enumerate(taken.items()):
            n_broken = _n_broken(space, engine, yardstick, excluded, Random(number))
            yield [Shown(bound, n_broken[bound.column]) for bound in bounds]


def _bounds(space: SearchSpace, engine: Engine, seed: int) -> Iterator[tuple[Excluded, Bound]]:
    """Yield some bounds of one search, chosen at random."""
    search = Cover(space, CampaignSettings(evaluations=1500, seed=seed))
    while not search.is_finished:
        outcomes = engine.evaluate_many(search.ask())
        search.tell([Score(0.0, (), _flown(outcome)) for outcome in outcomes])
    known = search.known
    for column in Random(seed).sample([*known.sets], N_BOUNDED):
        if known.n_kept[column]:
            yield frozenset(known.sets[column]), Bound(column, known.bound(column))


def _n_broken(
    space: SearchSpace, engine: Engine, yardstick: Yardstick, excluded: Excluded, random: Random
) -> Counter[Column]:
    """Return how many fresh specifications without some sets break each column."""

    def is_allowed(faults: frozenset[str]) -> bool:
        return not any(known <= faults for known in excluded)

    n_broken: Counter[Column] = Counter()
    for _ in range(N_FRESH // _BATCH):
        fresh = [varied_specification(space, 20, random, is_allowed) for _ in range(_BATCH)]
        for outcome in engine.evaluate_many(fresh):
            n_broken.update(yardstick.broken(_flown(outcome)))
    return n_broken


def _flown(outcome: object) -> Outcome:
    if not isinstance(outcome, Outcome):
        raise SystemExit(str(outcome))
    return outcome


def main() -> None:
    """Print a line for each mission, and one for each bound that does not hold."""
    for mission in sys.argv[1:] or MISSIONS:
        together = [*shown(load_code(Path("generated") / mission))]
        found = [each for some in together for each in some]
        n_held = sum(each.is_held for each in found)
        print(
            f"{mission}: {n_held} of {len(found)} bounds hold, against {N_FRESH:,} specifications "
            f"for each of {len(together)} choices of sets to leave out"
        )
        for each in found:
            if not each.is_held:
                (goal, measure), chance = each.bound
                print(f"  {goal} {measure}: bound {chance:.5f}, shown {each.n_broken / N_FRESH}")
        sys.stdout.flush()


if __name__ == "__main__":
    main()
