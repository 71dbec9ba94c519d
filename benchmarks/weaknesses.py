"""What share of a mission's weaknesses ``cover`` finds, held against brute force.

Run ``python -m benchmarks.weaknesses [MISSION ...]`` from the project's folder. Brute force, which
uses nothing of ``causes`` and ``search``, flies every fault of the pool alone in 300 forms and
every pair in 60, each in five mission seeds. A weakness is a goal, a measure, and a fault, or a
pair of which no part breaks the goal in any seed, that breaks it in one form in all five.
"""

import json
import subprocess
import sys
import tempfile
from collections.abc import Iterable, Iterator, Sequence
from itertools import combinations
from pathlib import Path
from random import Random
from typing import NamedTuple

from mrsfi_runtime.engine.settings import EngineSettings
from mrsfi_runtime.mission import MissionCode, load_code
from mrsfi_runtime.model.bounds import value_bounds
from mrsfi_runtime.model.faults import Fault, Specification, TimedFault
from mrsfi_runtime.model.mission import Mission
from mrsfi_runtime.model.outcome import Outcome
from mrsfi_runtime.model.targets import conflicts

MISSIONS = ("uuv_sampling", "tight_margins", "tight_energy")
SEEDS = (1, 2, 3, 4, 5)
N_ALONE, N_PAIR = 300, 60
N_RUNS = 6
EVALUATIONS = (300, 909, 3000)

Told = frozenset[tuple[str, str, frozenset[str]]]
"""Weaknesses: goal, measure, faults."""


class Judged(NamedTuple):
    """A goal by a measure."""

    goal: str
    measure: str


class Brute:
    """Flies forms of faults in several mission seeds, and tells what they break."""

    def __init__(self, code: MissionCode, random: Random) -> None:
        self._mission, self._pool = code.mission, code.pool
        self._random = random
        self._bounds = {fault.id: value_bounds(code.mission, fault) for fault in code.pool}
        self._places = [*_places(code.mission)]
        self._engine = EngineSettings("compiled").open(code, SEEDS[0], 2)
        self._most = {}
        for seed in SEEDS:
            (outcome,) = self._engine.evaluate_many([()], seed)
            self._most[seed] = self._counts(outcome)

    def weaknesses(self) -> Told:
        """Return what single faults and pairs break."""
        alone = [(self._form(fault),) for fault in self._pool for _ in range(N_ALONE)]
        flown = self._broken(alone)
        surely = {(j, faults_of(s)) for s in alone for j in frozenset.intersection(*flown[s])}
        ever = {(j, faults_of(s)) for s in alone for j in frozenset.union(*flown[s])}
        return frozenset((*judged, faults) for judged, faults in surely | self._joint(ever))

    def _joint(
        self, ever: set[tuple[Judged, frozenset[str]]]
    ) -> set[tuple[Judged, frozenset[str]]]:
        """Return the pairs of which no part ever breaks what they break."""

        def is_new(judged: Judged, pair: Specification) -> bool:
            return all((judged, faults_of((timed,))) not in ever for timed in pair)

        pairs = [*self._pairs()]
        first = self._broken(pairs, SEEDS[:1])
        some = [pair for pair in pairs if any(is_new(j, pair) for j in first[pair][0])]
        flown = self._broken(some)
        parts = self._broken([(timed,) for pair in some for timed in pair])
        return {
            (judged, faults_of(pair))
            for pair in some
            for judged in frozenset.intersection(*flown[pair])
            if is_new(judged, pair)
            and not any(judged in broken for timed in pair for broken in parts[timed,])
        }

    def _pairs(self) -> Iterator[Specification]:
        excluded = conflicts(self._mission, self._pool)
        for one, other in combinations(self._pool, 2):
            for _ in range(N_PAIR):
                first, second = self._form(one), self._form(other)
                is_apart = first.finish < second.start or second.finish < first.start
                if is_apart or other.id not in excluded[one.id]:
                    yield first, second

    def _form(self, fault: Fault) -> TimedFault:
        last, random = self._mission.duration - 1, self._random
        start, finish = sorted((random.randint(0, last), random.randint(0, last)))
        window = (0, last) if random.random() < 0.5 else (start, finish)
        return TimedFault(fault.id, *window, self._values(fault))

    def _values(self, fault: Fault) -> tuple[float, ...]:
        bounds, kind = self._bounds[fault.id], self._random.randrange(3)
        values = fault.values
        if kind == 1 and fault.kind.is_place:
            values = (*self._random.choice(self._places), *fault.values[2:])
        elif kind == 1:
            values = tuple(self._random.choice(each) for each in bounds)
        elif kind == 2:
            values = tuple(self._random.uniform(*each) for each in bounds)
        limited = zip(fault.kind.parameters, values, bounds, strict=True)
        return tuple(
            min(max(float(round(value)) if parameter.is_integer else value, low), high)
            for parameter, value, (low, high) in limited
        )

    def _broken(
        self, specifications: Sequence[Specification], seeds: Sequence[int] = SEEDS
    ) -> dict[Specification, list[frozenset[Judged]]]:
        """Return what each specification breaks, in every seed."""
        margin = 0.05 * self._mission.duration
        found: dict[Specification, list[frozenset[Judged]]] = {s: [] for s in specifications}
        for seed in seeds:
            outcomes = self._engine.evaluate_many([*found], seed)
            for specification, outcome in zip(found, outcomes, strict=True):
                counts, most = self._counts(outcome), self._most[seed]
                broken = (j for j in counts if counts[j] > most[j] + margin * (most[j] > 0))
                found[specification].append(frozenset(broken))
        return found

    def _counts(self, outcome: Outcome) -> dict[Judged, int]:
        return {
            Judged(goal, measure): getattr(outcome, measure)[place]
            for place, goal in enumerate(self._mission.goal_ids)
            for measure in ("believed", "true", "missed")
        }


def _places(mission: Mission) -> Iterator[tuple[float, float]]:
    """Yield where robots begin, obstacles stand, goals are pursued, and what is outside."""
    areas = [mission.area, *(obstacle.area for obstacle in mission.obstacles)]
    areas += [goal.area for goal in mission.goals if goal.area is not None]
    yield from ((robot.position.x, robot.position.y) for robot in mission.robots)
    yield from ((area.center.x, area.center.y) for area in areas)
    for x, y in ((1.3, 0.0), (-1.3, 0.0), (0.0, 1.3), (0.0, -1.3)):
        center, radius = mission.area.center, mission.area.radius
        yield center.x + x * radius, center.y + y * radius


def faults_of(specification: Specification) -> frozenset[str]:
    """Return the pool faults of a specification."""
    return frozenset(timed.fault for timed in specification)


def found_by_cover(mission: str, seed: int, n_evaluations: int) -> Told:
    """Return the weaknesses that a campaign prints."""
    with tempfile.TemporaryDirectory() as folder:
        run = Path(folder) / "run"
        limits = ("--evaluations", n_evaluations, "--seed", seed, "--out", run)
        _mrsfi("evolve", mission, "--algorithm", "cover", "--no-explain", *limits)
        found = json.loads(_mrsfi("weaknesses", run, "--json"))
    return frozenset((w["goal"], w["measure"], frozenset(w["faults"])) for w in found)


def _mrsfi(*words: object) -> str:
    command = [sys.executable, "-m", "mrsfi_runtime.cli.main", *map(str, words)]
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


def _share(told: Iterable[Told], known: Told) -> str:
    """Return the least and the greatest share of what is known that is told."""
    shares = [len(known & each) / len(known) for each in told] if known else []
    return f"{min(shares):.2f} to {max(shares):.2f}" if shares else "–"


def main() -> None:
    """Print a table for each mission."""
    for mission in sys.argv[1:] or MISSIONS:
        known = Brute(load_code(Path("generated") / mission), Random(77)).weaknesses()
        single = frozenset(each for each in known if len(each[2]) == 1)
        print(f"{mission}: {len(single)} single faults, {len(known - single)} pairs break a goal")
        for n_evaluations in EVALUATIONS:
            told = [found_by_cover(mission, seed, n_evaluations) for seed in range(1, N_RUNS + 1)]
            shares = f"single {_share(told, single)}, pairs {_share(told, known - single)}"
            print(f"  cover, {n_evaluations:>5} evaluations: {shares}", flush=True)


if __name__ == "__main__":
    main()
