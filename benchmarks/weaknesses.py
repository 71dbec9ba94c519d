"""What share of a mission's weaknesses campaigns find, beside brute force.

Run ``python -m benchmarks.weaknesses [MISSION ...] [--algorithms cover ...]`` from the project's
folder. ``cover`` searches with as many evaluations as the table says, others with the default. A
mission is one of ``models`` or of ``benchmarks/missions``, whose goals need some members only.

Brute force, which uses nothing of ``causes`` and ``search``, flies every fault of the pool alone in
300 variants, every pair in 60 and every triple in 20, each in five mission seeds. A weakness is a
goal, a measure, and a set of faults that breaks it in one variant in all five, while no part of the
set breaks it in any seed. What a campaign finds is *right* if brute force finds it, too, and
*refuted* if brute force has seen a part break the goal. Both are asked of sets that hold in at
least five mission seeds, all of those that were flown.
"""

import argparse
import json
import shutil
import subprocess
import sys
import tempfile
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from itertools import combinations, starmap
from pathlib import Path
from random import Random
from statistics import fmean
from typing import Any, NamedTuple, TypeAlias

from mrsfi import load
from mrsfi_runtime.engine.opening import open_engine
from mrsfi_runtime.generated_code import MissionCode, load_code
from mrsfi_runtime.model.faults import Fault, Gate, Specification, TimedFault, value_bounds
from mrsfi_runtime.model.mission import Mission, Outcome
from mrsfi_runtime.record.engine_settings import EngineSettings

MISSIONS = ("uuv_sampling", "tight_margins", "tight_energy", "teams", "few")
MRSFI = (sys.executable, "-m", "mrsfi_runtime.cli.main")
SEEDS = (1, 2, 3, 4, 5)
N_ALONE, N_PAIR, N_TRIPLE = 300, 60, 20
N_RUNS = 6
EVALUATIONS = (300, 909, 2000, 3000)


@contextmanager
def project_of(name: str) -> Iterator[tuple[Path, Path]]:
    """Yield the models and the generated code of a mission."""
    here = Path(__file__).parent / "missions" / name
    if not here.exists():
        yield Path("models") / name, Path("generated") / name
        return
    with tempfile.TemporaryDirectory() as folder:
        models = Path(folder) / "models" / name
        shutil.copytree(here, models)
        subprocess.run([*MRSFI, "generate", str(models)], check=True, stdout=subprocess.DEVNULL)
        yield models, Path(folder) / "generated" / name


class Judged(NamedTuple):
    """A goal by a measure."""

    goal: str
    measure: str


class Weakness(NamedTuple):
    """A goal by a measure, and a set of faults that breaks it."""

    judged: Judged
    faults: frozenset[str]


Weaknesses: TypeAlias = frozenset[Weakness]


class Known(NamedTuple):
    """What brute force has seen break goals: in all mission seeds, and a fault alone in any."""

    surely: Weaknesses
    ever: Weaknesses

    def refutes(self, told: Weakness) -> bool:
        """Return whether a part of a set was seen to be enough."""
        return any(each.judged == told.judged and each.faults < told.faults for each in self.ever)


class Brute:
    """Flies forms of faults in several mission seeds, and tells what they break."""

    def __init__(self, code: MissionCode, random: Random) -> None:
        self._mission, self._pool = code.mission, code.pool
        self._random = random
        self._bounds = {fault.id: value_bounds(code.mission, fault) for fault in code.pool}
        self._places = [*_places(code.mission)]
        self._excluded = Gate(code.mission, code.pool).conflicts()
        self._engine = open_engine(EngineSettings("compiled"), code, SEEDS[0], 2)
        self._most = {}
        for seed in SEEDS:
            (outcome,) = self._engine.evaluate_many([()], seed)
            self._most[seed] = self._counts(outcome)

    def known(self) -> Known:
        """Return what single faults and pairs break."""
        alone = [(self._form(fault),) for fault in self._pool for _ in range(N_ALONE)]
        flown = self._broken(alone)
        surely = _weaknesses((s, frozenset.intersection(*flown[s])) for s in alone)
        ever = _weaknesses((s, frozenset.union(*flown[s])) for s in alone)
        for n_faults, n_forms in ((2, N_PAIR), (3, N_TRIPLE)):
            new, seen = self._joint(n_faults, n_forms, ever)
            surely, ever = surely | new, ever | seen
        return Known(surely, ever)

    def _joint(self, size: int, n_forms: int, ever: Weaknesses) -> tuple[Weaknesses, Weaknesses]:
        """Return what sets break surely, and ever, that no part of them ever breaks."""
        by = defaultdict(list)
        for each in ever:
            by[each.judged].append(each.faults)

        def is_new(judged: Judged, faults: frozenset[str]) -> bool:
            return not any(part <= faults for part in by[judged])

        def news(flown: Iterable[frozenset[Judged]], faults: frozenset[str]) -> set[Judged]:
            return {judged for each in flown for judged in each if is_new(judged, faults)}

        surely, seen = set(), set()
        sets = [*combinations(self._pool, size)]
        for first in range(0, len(sets), 500):
            drawn = [*self._drawn(sets[first : first + 500], n_forms, is_new)]
            flown = self._broken(drawn, SEEDS[:1])
            some = [each for each in drawn if news(flown[each], faults_of(each))]
            seen |= {
                (judged, faults_of(each))
                for each in some
                for judged in news(flown[each], faults_of(each))
            }
            in_all = self._broken(some)
            parts = self._broken([part for each in some for part in _parts(each)])
            surely |= {
                (judged, faults_of(each))
                for each in some
                for judged in frozenset.intersection(*in_all[each])
                if is_new(judged, faults_of(each))
                and not any(judged in broken for part in _parts(each) for broken in parts[part])
            }
        return frozenset(starmap(Weakness, surely)), frozenset(starmap(Weakness, seen))

    def _drawn(
        self,
        sets: Iterable[Sequence[Fault]],
        n_forms: int,
        is_new: Callable[[Judged, frozenset[str]], bool],
    ) -> Iterator[Specification]:
        """Yield specifications of sets that could be needed for some goal and measure."""
        columns = [*self._most[SEEDS[0]]]
        for faults in sets:
            named = frozenset(fault.id for fault in faults)
            for _ in range(n_forms if any(is_new(judged, named) for judged in columns) else 0):
                drawn = tuple(self._form(fault) for fault in faults)
                if not any(starmap(self._clash, combinations(drawn, 2))):
                    yield drawn

    def _clash(self, one: TimedFault, other: TimedFault) -> bool:
        is_apart = one.finish < other.start or other.finish < one.start
        return not is_apart and other.fault in self._excluded[one.fault]

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


def _parts(specification: Specification) -> Iterator[Specification]:
    """Yield a specification without each of its faults."""
    yield from combinations(specification, len(specification) - 1)


def faults_of(specification: Specification) -> frozenset[str]:
    """Return the pool faults of a specification."""
    return frozenset(timed.fault for timed in specification)


def _weaknesses(
    broken: Iterable[tuple[Specification, frozenset[Judged]]],
) -> Weaknesses:
    return frozenset(
        Weakness(judged, faults_of(specification))
        for specification, columns in broken
        for judged in columns
    )


def told_by(
    models: Path, algorithm: str, seed: int, n_evaluations: int | None, n_seeds: int | None
) -> list[dict[str, Any]]:
    """Search, and return the weaknesses that are printed; what is left out is as usual."""
    settings = {"algorithm": algorithm, "seed": seed, "evaluations": n_evaluations}
    given = {name: value for name, value in settings.items() if value is not None}
    seeds = [] if n_seeds is None else ["--seeds", str(n_seeds)]
    with tempfile.TemporaryDirectory() as folder:
        run = Path(folder) / "run"
        load(models).evolve("a", out=run, explain=algorithm != "cover", **given)
        command = [*MRSFI, "weaknesses", str(run), *seeds, "--json"]
        told = subprocess.run(command, check=True, stdout=subprocess.PIPE).stdout
        found: list[dict[str, Any]] = json.loads(told)
    return found


def weakness_of(told: Mapping[str, Any]) -> Weakness:
    """Return a weakness as brute force has it."""
    return Weakness(Judged(told["goal"], told["measure"]), frozenset(told["faults"]))


def by_number_of_faults(known: Known) -> dict[str, Weaknesses]:
    """Return what brute force knows, by the number of faults."""
    return {
        size: frozenset(each for each in known.surely if len(each.faults) == n_faults)
        for n_faults, size in enumerate(("single", "pairs", "triples"), 1)
    }


def found_share(told: Iterable[Weaknesses], known: Weaknesses) -> str:
    """Return the mean, the least and the greatest share of what is known that is found."""
    return _between([len(known & each) / len(known) for each in told] if known else [])


def right_shares(told: Iterable[list[dict[str, Any]]], known: Known) -> tuple[str, str]:
    """Return, as above, the share of what is found for sure that is right, or refuted."""
    right, refuted = [], []
    for each in told:
        held = (w for w in each if w["seeds"]["held"] == w["seeds"]["of"] >= len(SEEDS))
        if sure := [w for w in map(weakness_of, held) if len(w.faults) <= 3]:
            right.append(sum(w in known.surely for w in sure) / len(sure))
            refuted.append(sum(map(known.refutes, sure)) / len(sure))
    return _between(right), _between(refuted)


def _between(shares: list[float]) -> str:
    if not shares:
        return "–"
    return f"{fmean(shares):.2f} ({min(shares):.2f} to {max(shares):.2f})"


def print_table(models: Path, known: Known, algorithms: Iterable[str]) -> None:
    """Print a line for each algorithm and number of evaluations."""
    by_size = by_number_of_faults(known)
    for algorithm in algorithms:
        is_cover = algorithm == "cover"
        n_seeds = len(SEEDS) if is_cover else None
        for n_evaluations in EVALUATIONS if is_cover else (None,):
            told = [
                told_by(models, algorithm, seed, n_evaluations, n_seeds)
                for seed in range(1, N_RUNS + 1)
            ]
            found = [frozenset(map(weakness_of, each)) for each in told]
            right, refuted = right_shares(told, known)
            n = "default" if n_evaluations is None else f"{n_evaluations:,}"
            print(
                f"  {algorithm:6} {n:>7}: "
                + ", ".join(f"{size} {found_share(found, by_size[size])}" for size in by_size)
                + f", together {found_share(found, known.surely)}; right {right}, "
                f"refuted {refuted}",
                flush=True,
            )


def print_ladder(models: Path, known: Known) -> None:
    """Print how many elements close what a default campaign found, and what brute force knows."""
    truly = [each for each in known.surely if each.judged.measure != "believed"]
    for seed in (1, 2, 3):
        with tempfile.TemporaryDirectory() as folder:
            run = Path(folder) / "run"
            load(models).evolve("a", out=run, seed=seed)
            subprocess.run([*MRSFI, "report", str(run)], check=True, stdout=subprocess.DEVNULL)
            found = json.loads((run / "summary.json").read_text())["weaknesses"]["protect"]
        kept_out = {fault for step in found for fault in step["faults"]}
        n_closed = sum(not each.faults.isdisjoint(kept_out) for each in truly)
        elements = ", ".join(step["element"] for step in found)
        n_found, n_gone = (sum(len(step[key]) for step in found) for key in ("closes", "gone"))
        print(
            f"  protect {elements}: {n_gone} of {n_found} weaknesses gone, "
            f"{n_closed} of {len(truly)} true ones closed",
            flush=True,
        )


def main() -> None:
    """Print a table for each mission."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("missions", nargs="*", metavar="MISSION", default=MISSIONS)
    parser.add_argument("--algorithms", nargs="+", metavar="NAME", default=["cover"])
    arguments = parser.parse_args()
    for name in arguments.missions:
        with project_of(name) as (models, generated):
            known = Brute(load_code(generated), Random(77)).known()
            sizes = ", ".join(f"{len(s)} {size}" for size, s in by_number_of_faults(known).items())
            print(f"{name}: {sizes}", flush=True)
            print_table(models, known, arguments.algorithms)
            print_ladder(models, known)


if __name__ == "__main__":
    main()
