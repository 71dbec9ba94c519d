"""Whether weaknesses are what campaigns say: their witnesses flown again by the public API.

Run ``python -m benchmarks.reflown [MISSION ...]`` from the project's folder. What is broken is
judged here, anew: a count above that of the flight without faults, by more than 5 % of the ticks if
that is above 0 already. Of the weaknesses of some campaigns some are drawn; each is flown in the
campaign's mission seed, where its witness has to break the goal and no part of the witness may, and
in the mission seeds that ``mrsfi weaknesses --seeds`` looks at, where it has to hold in as many.
Of all weaknesses, each fault is a claim that the goal does not break as well without it.
"""

import sys
import tempfile
from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import combinations
from pathlib import Path
from random import Random
from typing import Any, NamedTuple

import mrsfi
from benchmarks.drawn_missions import DRAWN, drawn_mission
from benchmarks.weaknesses import MISSIONS, told_by

SEARCHES = (21, 22, 23)
N_EVALUATIONS = 909
N_SEEDS = 20
N_DRAWN = 300
MISSION_SEED = 1


class Told(NamedTuple):
    """A weakness of a mission, as a campaign tells it."""

    goal: str
    measure: str
    witness: mrsfi.Specification
    n_held: int


class Flights:
    """Flies specifications of a mission, each once in a mission seed, and tells what breaks."""

    def __init__(self, mission: mrsfi.Mission) -> None:
        self._mission = mission
        self._margin = 0.05 * mission.model.duration
        self._goals = [goal.id for goal in mission.model.goals]
        self._flown: dict[tuple[mrsfi.Specification, int], Any] = {}

    def fly(self, specifications: Iterable[mrsfi.Specification], seed: int) -> None:
        """Fly what is not flown yet, and the mission without faults."""
        new = [s for s in dict.fromkeys([(), *specifications]) if (s, seed) not in self._flown]
        flown = self._mission.evaluate(new, seed)
        self._flown.update(zip(((s, seed) for s in new), flown, strict=True))

    def breaks(self, told: Told, specification: mrsfi.Specification, seed: int) -> bool:
        """Return whether a goal breaks under what was flown."""
        usual, found = (
            getattr(self._flown[flown, seed], told.measure)[self._goals.index(told.goal)]
            for flown in ((), specification)
        )
        return bool(found > usual + (self._margin if usual else 0))


def parts(witness: mrsfi.Specification) -> Iterator[mrsfi.Specification]:
    """Yield what is left of a witness without some of its faults, at least one of each."""
    for n in range(1, len(witness)):
        yield from combinations(witness, n)


def fewer(witness: mrsfi.Specification) -> Iterator[mrsfi.Specification]:
    """Yield what is left of a witness without one of its faults."""
    return combinations(witness, len(witness) - 1)


def told_of(mission: mrsfi.Mission, seed: int) -> Iterator[Told]:
    """Yield the weaknesses of a campaign."""
    found = told_by(mission.folders.models, "cover", seed, N_EVALUATIONS, N_SEEDS)
    for each in found:
        witness = tuple(_timed(mission, timed) for timed in each["witness"])
        yield Told(each["goal"], each["measure"], witness, each["seeds"]["held"])


def _timed(mission: mrsfi.Mission, told: Mapping[str, Any]) -> mrsfi.TimedFault:
    values = mission.pool[told["fault"]].kind.named(told["values"])
    return mission.timed(told["fault"], told["start"], told["finish"], **values)


def wrong_claims(flights: Flights, told: Sequence[Told]) -> tuple[int, int]:
    """Return how many faults are named without which the goal breaks as well, and of how many."""
    flights.fly((left for each in told for left in fewer(each.witness)), MISSION_SEED)
    claims = [flights.breaks(w, left, MISSION_SEED) for w in told for left in fewer(w.witness)]
    return sum(claims), len(claims)


def seen(flights: Flights, drawn: Sequence[Told]) -> tuple[int, int, int]:
    """Return how many break, have a part that breaks, and hold in as many seeds as was told."""
    flown = [s for each in drawn for s in (each.witness, *parts(each.witness))]
    flights.fly(flown, MISSION_SEED)
    n_broken = sum(flights.breaks(each, each.witness, MISSION_SEED) for each in drawn)
    n_larger = sum(
        any(flights.breaks(each, part, MISSION_SEED) for part in parts(each.witness))
        for each in drawn
    )
    seeds = range(MISSION_SEED, MISSION_SEED + N_SEEDS)
    for seed in seeds:
        flights.fly((s for each in drawn for s in (each.witness, *fewer(each.witness))), seed)
    n_equal = sum(
        each.n_held
        == sum(
            flights.breaks(each, each.witness, seed)
            and not any(flights.breaks(each, left, seed) for left in fewer(each.witness))
            for seed in seeds
        )
        for each in drawn
    )
    return n_broken, n_larger, n_equal


def main() -> None:
    """Print a line for each mission, and the sums."""
    names = sys.argv[1:] or MISSIONS
    with tempfile.TemporaryDirectory() as place:
        missions = {
            name: mrsfi.load(drawn_mission(Path(place), name) if name in DRAWN else name)
            for name in names
        }
        told = {
            name: [each for seed in SEARCHES for each in told_of(mission, seed)]
            for name, mission in missions.items()
        }
        every = [(name, each) for name, found in told.items() for each in found]
        chosen = Random(1).sample(every, min(N_DRAWN, len(every)))
        sums = [0] * 7
        for name, mission in missions.items():
            flights = Flights(mission)
            drawn = [each for of, each in chosen if of == name]
            n_several = sum(len(each.witness) > 1 for each in drawn)
            judged = (*seen(flights, drawn), *wrong_claims(flights, told[name]))
            found = (len(drawn), n_several, *judged)
            sums = [*map(sum, zip(sums, found, strict=True))]
            print(f"{name}: {_words(found)}", flush=True)
        print(f"together: {_words(sums)}")


def _words(found: Sequence[int]) -> str:
    n, n_several, n_broken, n_larger, n_equal, n_wrong, n_claims = found
    return (
        f"of {n} weaknesses, {n_several} of several faults, {n_broken} break their goal again, "
        f"{n_larger} with a part as well, {n_equal} hold in as many of {N_SEEDS} mission seeds as "
        f"told; of {n_claims:,} faults named by all, the goal breaks as well without {n_wrong}"
    )


if __name__ == "__main__":
    main()
