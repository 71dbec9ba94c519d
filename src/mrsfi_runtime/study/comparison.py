"""Compare searches: algorithms, or settings of one algorithm, by the results of their runs.

Each setup runs with the same seeds and the same number of evaluations. ``variants_of`` and
``Sweep`` list the setups, ``measure_run`` turns a campaign into a ``RunResult``, and ``compare``
returns quartiles and tests for each criterion. A rank test assumes no distribution. p-values are
adjusted for the number of tests. A run that never reached a number of goals ranks last.

References
----------
Source paper, section V, RQ1, and VII. A. Arcuri and L. Briand, "A Hitchhiker's Guide to Statistical
Tests for Assessing Randomized Algorithms in Software Engineering", Software Testing, Verification
and Reliability 24, 2014. H. B. Mann and D. R. Whitney, "On a Test of Whether one of Two Random
Variables is Stochastically Larger than the Other", Annals of Mathematical Statistics 18, 1947;
A. Vargha and H. D. Delaney, "A Critique and Improvement of the CL Common Language Effect Size
Statistics of McGraw and Wong", Journal of Educational and Behavioral Statistics 25, 2000; S. Holm,
"A Simple Sequentially Rejective Multiple Test Procedure", Scandinavian Journal of Statistics 6,
1979.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from fractions import Fraction
from itertools import accumulate, combinations, product
from math import comb, inf, isfinite
from pathlib import Path
from types import MappingProxyType
from typing import Any, Self, TypeAlias

import numpy as np
from moocore import hypervolume
from numpy.typing import NDArray
from scipy.stats import PermutationMethod, mannwhitneyu

from mrsfi_runtime.analysis.fronts import Columns, find_front, is_more
from mrsfi_runtime.analysis.story import first
from mrsfi_runtime.errors import UsageError, expected
from mrsfi_runtime.model.mission import Mission
from mrsfi_runtime.record.database import object_from_text
from mrsfi_runtime.record.settings import ALGORITHM_NAMES, CampaignSettings
from mrsfi_runtime.record.store import CampaignStore, Measure

Value: TypeAlias = int | float

_MOST = 100  # values of a setting between two
_SYNTAX = f"KEY=LOW:HIGH:N, N from 2 to {_MOST}, or KEY=A,B,C, several with commas between"

PAPERS: Mapping[str, Value] = MappingProxyType(
    {
        key: value
        for key, value in asdict(CampaignSettings()).items()
        if type(value) in (int, float) and key not in ("seed", "generations", "max_failures")
    }
)
"""Numeric settings that a sweep can vary, with the paper's values; seeds and limits of a run are
left out."""


@dataclass(frozen=True, slots=True)
class Variant:
    """A setup of a search: its name, and the values that it replaces in the campaign file."""

    name: str
    overrides: Mapping[str, str | Value]


def variants_of(algorithms: object, sweep: "Sweep | None" = None) -> tuple[Variant, ...]:
    """Return a setup for each algorithm, or those of a sweep; raise a ``UsageError`` else."""
    found = algorithms if isinstance(algorithms, list | tuple) else ()
    variants = [
        Variant(each, {"algorithm": each}) if isinstance(each, str) else each for each in found
    ]
    names = [each.name for each in variants]
    if not names or len({*names}) < len(names):
        known = expected(algorithms, ALGORITHM_NAMES, "a list of different ones of")
        raise UsageError(f"algorithms: found {algorithms!r}; {known}")
    if sweep is None:
        return tuple(variants)
    if len(names) > 1:
        raise UsageError(f"algorithms: found {names}; expected one, whose settings are swept")
    setups = sweep.settings().items()
    return tuple(Variant(name, {"algorithm": names[0], **values}) for name, values in setups)


@dataclass(frozen=True, slots=True)
class Sweep:
    """Settings of one algorithm with the values of each, which are all combined."""

    values: Mapping[str, tuple[Value, ...]]

    @classmethod
    def parse(cls, text: str) -> Self:
        """Read ``crossover=0.3:0.9:5,population=10,20,40``."""
        found: dict[str, tuple[Value, ...]] = {}
        key = ""
        for part in text.split(","):
            name, is_named, numbers = part.rpartition("=")
            if is_named:
                key = name.strip()
                if key not in PAPERS or key in found:
                    known = expected(key, [each for each in PAPERS if each not in found])
                    raise UsageError(f"sweep: found {part.strip()!r}; {known}")
            values = _numbers(numbers) if key else ()
            if not values:
                raise UsageError(f"sweep: found {part.strip()!r}; expected {_SYNTAX}")
            found[key] = tuple(dict.fromkeys((*found.get(key, ()), *values)))
        return cls(found)

    @property
    def papers(self) -> str:
        """Name of the setup with the paper's values."""
        return _name({key: PAPERS[key] for key in self.values})

    def settings(self) -> Mapping[str, Mapping[str, Value]]:
        """Return the values of each setup by its name; the paper's come last if they are new."""
        combined = product(*self.values.values())
        grid = [dict(zip(self.values, chosen, strict=True)) for chosen in combined]
        return {_name(each): each for each in (*grid, {key: PAPERS[key] for key in self.values})}

    def with_values(self, values: Mapping[str, Value]) -> set[str]:
        """Return names of combinations that have these values; the paper's need not be one."""
        found = {name for name, each in self.settings().items() if values.items() <= each.items()}
        is_combined = all(PAPERS[key] in known for key, known in self.values.items())
        return found if is_combined else found - {self.papers}

    def as_json(self) -> dict[str, Any]:
        """Return its values, and those of each setup by its name, as values of JSON."""
        values = {key: list(each) for key, each in self.values.items()}
        return {"values": values, "papers": self.papers, "settings": dict(self.settings())}


def _numbers(text: str) -> tuple[Value, ...]:
    """Return the number in a text, or evenly spaced ones; none if the text is wrong."""
    try:
        low, *others = map(Fraction, text.split(":"))
        high, n = others or (low, Fraction(1))
    except (ValueError, ZeroDivisionError):
        return ()
    if n.denominator != 1 or not 2 * bool(others) <= n <= _MOST:
        return ()
    step = (high - low) / max(1, int(n) - 1)
    exact = (low + step * place for place in range(int(n)))
    return tuple(int(each) if each.denominator == 1 else float(each) for each in exact)


def _name(values: Mapping[str, Value]) -> str:
    return ",".join(f"{key}={value}" for key, value in values.items())


SCHEMA = 1
"""Version of ``comparison.json``."""

MOST_OBJECTIVES = 7
"""Limit for the hypervolume, whose cost grows exponentially with the number of objectives."""

_MOST_EXACT = 20_000  # divisions of the pooled values that an exact test enumerates
_SIGNIFICANT = 0.05


@dataclass(frozen=True, slots=True)
class RunResult:
    """Result of one setup with one seed.

    ``improvements`` lists each new best fitness after its number of evaluations. ``at_once`` has,
    for k = 1, 2, …, the number of evaluations until one specification broke k goals, or ``None``,
    shape ``(n_goals,)``; ``together`` the same until all specifications so far broke k goals.
    ``hypervolume`` comes from ``front_volume``. ``front_size`` counts different vectors.
    ``seconds`` is wall time.
    """

    algorithm: str
    seed: int
    n_evaluations: int
    n_failures: int
    improvements: tuple[tuple[int, float], ...]
    at_once: tuple[int | None, ...]
    together: tuple[int | None, ...]
    hypervolume: float | None
    front_size: int
    seconds: float
    digest: str

    @property
    def best_fitness(self) -> float:
        """Highest fitness of all evaluations; 0 without any."""
        return self.improvements[-1][1] if self.improvements else 0.0

    def best_after(self, n_evaluations: int) -> float:
        """Return the highest fitness of the first ``n_evaluations``."""
        return max(
            (value for place, value in self.improvements if place <= n_evaluations), default=0.0
        )

    @classmethod
    def from_text(cls, text: str) -> Self:
        """Return the result whose fields a JSON text has."""
        return cls(**{key: _frozen(value) for key, value in object_from_text(text).items()})


def _frozen(value: Any) -> Any:
    return tuple(map(_frozen, value)) if isinstance(value, list) else value


def measure_run(store: CampaignStore, mission: Mission, seconds: float) -> RunResult:
    """Return the result of a search, in the first mission seed."""
    settings = store.settings
    measure = replace(Measure.of(settings, mission), n_seeds=1)
    columns = Columns.read(store, measure, measure.goals)
    is_broken = columns.violations > 0
    is_improved = np.flatnonzero(is_more(columns.fitness))
    best = [mission.duration] * len(measure.chosen)
    points = find_front(measure, columns, measure.chosen).points
    front = [point.violations for point in points]
    if measure.minimised is not None:
        most = settings.faults * (mission.duration if measure.minimised == "fault_ticks" else 1)
        best.append(most - 1)
        front = [(*point.violations, most - point.cost) for point in points]
    return RunResult(
        algorithm=settings.algorithm,
        seed=settings.seed,
        n_evaluations=len(columns),
        n_failures=store.n_failures,
        improvements=tuple((k + 1, columns.fitness[k].item()) for k in is_improved.tolist()),
        at_once=_reached(is_broken.sum(axis=1), len(mission.goals)),
        together=_reached(np.logical_or.accumulate(is_broken).sum(axis=1), len(mission.goals)),
        hypervolume=front_volume(front, best),
        front_size=len(front),
        seconds=seconds,
        digest=store.digest(),
    )


def _reached(n_broken: NDArray[Any], n_goals: int) -> tuple[int | None, ...]:
    """Return the places, from 1, at which 1, 2, … goals were broken; ``None`` for never."""
    firsts = [first(n_broken >= n) for n in range(1, n_goals + 1)]
    return tuple(None if place is None else place + 1 for place in firsts)


def front_volume(front: Sequence[tuple[float, ...]], best: Sequence[int]) -> float | None:
    """Return the hypervolume of a front, as a share of the possible volume.

    Points are integers from 0 on, larger is better; ``best`` is the best possible point. The
    reference point is ``(-1, …, -1)``, so that a front counts whose points violate only one goal.
    The volume is the share of all integer vectors that the front reaches or exceeds. ``None`` with
    fewer than two objectives, or more than ``MOST_OBJECTIVES``.
    """
    if not 2 <= len(best) <= MOST_OBJECTIVES:
        return None
    if not front:
        return 0.0
    shares = (np.array(front) + 1) / (np.array(best) + 1)
    return float(hypervolume(shares, ref=[0.0] * len(best), maximise=True))


@dataclass(frozen=True, slots=True)
class Quartiles:
    """Quartiles of a sample; infinite where it reaches infinity."""

    lower: float
    median: float
    upper: float


@dataclass(frozen=True, slots=True)
class RankTest:
    """Comparison of two samples.

    ``u`` is the Mann-Whitney U of the first sample: pairs in which its value is larger, ties half;
    ``a12`` is the share of such pairs. ``p_value`` is two-sided. ``method`` is ``exact`` over all
    divisions of the pooled values, or ``normal``, with corrections for ties and continuity.
    """

    u: float
    p_value: float
    method: str
    a12: float

    @property
    def magnitude(self) -> str:
        """Size of the effect, named as by Vargha and Delaney."""
        distance = max(self.a12, 1.0 - self.a12)
        words = {0.71: "large", 0.64: "medium", 0.56: "small"}
        return next((word for least, word in words.items() if distance >= least), "negligible")


def quartiles(values: Sequence[float]) -> Quartiles:
    """Return the quartiles of at least one value, with linear interpolation."""
    ordered = sorted(values)

    def quantile(share: float) -> float:
        below, rest = divmod(share * (len(ordered) - 1), 1.0)
        low, high = ordered[int(below)], ordered[min(int(below) + 1, len(ordered) - 1)]
        return low if rest == 0.0 or low == high else low + rest * (high - low)

    return Quartiles(*map(quantile, (0.25, 0.5, 0.75)))


def compare_ranks(first: Sequence[float], second: Sequence[float]) -> RankTest:
    """Compare two samples of at least one value each; infinite values have ranks, too.

    Exact up to 20,000 divisions of the pooled values into two such samples (8 against 8); beyond,
    and for a sample of one value, the normal approximation.
    """
    n_pairs = len(first) * len(second)
    if len({*first, *second}) == 1:
        return RankTest(n_pairs / 2, 1.0, "exact", 0.5)
    n_divisions = comb(len(first) + len(second), len(first))
    is_exact = n_divisions <= _MOST_EXACT and min(len(first), len(second)) > 1
    method = PermutationMethod(n_resamples=_MOST_EXACT) if is_exact else "asymptotic"
    found = mannwhitneyu(first, second, method=method)
    u = float(found.statistic)
    return RankTest(u, float(found.pvalue), "exact" if is_exact else "normal", u / n_pairs)


def holm(p_values: Sequence[float]) -> tuple[float, ...]:
    """Return p-values adjusted for multiple tests, in the given order."""
    n = len(p_values)
    by_size = sorted(range(n), key=p_values.__getitem__)
    raised = (min(1.0, (n - rank) * p_values[place]) for rank, place in enumerate(by_size))
    adjusted = dict(zip(by_size, accumulate(raised, max), strict=True))
    return tuple(adjusted[place] for place in range(n))


@dataclass(frozen=True, slots=True)
class Criterion:
    """A value of a run: more is better (``sign`` 1), less is better (-1), or shown only (0)."""

    name: str
    sign: int
    value: Callable[[RunResult], float]


@dataclass(frozen=True, slots=True)
class PairTest:
    """A test of two setups on one measure; ``a12`` above 0.5 means that the first is better."""

    measure: str
    first: str
    second: str
    ranks: RankTest
    holm_p_value: float

    @property
    def effect(self) -> str:
        """The magnitude in words, if the difference is significant."""
        return self.ranks.magnitude if self.holm_p_value < _SIGNIFICANT else "not shown"

    @property
    def verdict(self) -> str:
        """Whether the first is better or worse, if the difference is significant."""
        if self.holm_p_value >= _SIGNIFICANT:
            return "not shown"
        return "better" if self.ranks.a12 > 0.5 else "worse"

    def as_json(self) -> dict[str, Any]:
        """Return it as values of JSON."""
        names = {"measure": self.measure, "first": self.first, "second": self.second}
        ranks = {**asdict(self.ranks), "magnitude": self.ranks.magnitude}
        return names | ranks | {"holm_p_value": self.holm_p_value}


@dataclass(frozen=True, slots=True)
class Comparison:
    """Quartiles and tests of the runs of several setups, by measure.

    Each pair of algorithms is tested. In a sweep, whose setups stand in ``algorithms``, each setup
    is tested against the paper's.
    """

    algorithms: tuple[str, ...]
    seeds: tuple[int, ...]
    runs: tuple[RunResult, ...]
    criteria: tuple[Criterion, ...]
    quartiles: Mapping[str, Mapping[str, Quartiles]]
    tests: tuple[PairTest, ...]
    sweep: Sweep | None = None
    folder: Path = Path()

    def of(self, algorithm: str) -> tuple[RunResult, ...]:
        """Return the runs of a setup, by seed."""
        return tuple(run for run in self.runs if run.algorithm == algorithm)

    def with_values(self, values: Mapping[str, Value]) -> tuple[float, ...]:
        """Return the best fitness of runs of a sweep's combinations that have these values."""
        chosen = self.sweep.with_values(values) if self.sweep else ()
        return tuple(run.best_fitness for run in self.runs if run.algorithm in chosen)


def compare(
    algorithms: Sequence[str], runs: Sequence[RunResult], sweep: Sweep | None = None
) -> Comparison:
    """Compare setups, in this order, by runs on one mission with one number of evaluations."""
    pairs = [*combinations(algorithms, 2)]
    if sweep is not None:
        pairs = [(name, sweep.papers) for name in algorithms if name != sweep.papers]
    ordered = tuple(sorted(runs, key=lambda run: (algorithms.index(run.algorithm), run.seed)))
    criteria = _criteria(ordered)
    values = {
        criterion.name: {
            name: [criterion.value(run) for run in ordered if run.algorithm == name]
            for name in algorithms
        }
        for criterion in criteria
    }
    return Comparison(
        algorithms=tuple(algorithms),
        seeds=tuple(sorted({run.seed for run in runs})),
        runs=ordered,
        criteria=criteria,
        quartiles={
            measure: {name: quartiles(found) for name, found in by_algorithm.items()}
            for measure, by_algorithm in values.items()
        },
        tests=tuple(
            test
            for criterion in criteria
            if criterion.sign
            for test in _tests(criterion, values[criterion.name], pairs)
        ),
        sweep=sweep,
    )


def _criteria(runs: Sequence[RunResult]) -> tuple[Criterion, ...]:
    """Return the criteria of the runs, without numbers of goals that no run broke."""
    criteria = [Criterion("fitness", 1, lambda run: run.best_fitness)]
    if all(run.hypervolume is not None for run in runs):
        criteria.append(Criterion("hypervolume", 1, lambda run: run.hypervolume or 0.0))
    for name in ("at_once", "together"):
        n_most = max(sum(place is not None for place in getattr(run, name)) for run in runs)
        criteria += [_breaking(name, n_goals) for n_goals in range(1, n_most + 1)]
    size = Criterion("front_size", 0, lambda run: run.front_size)
    return (*criteria, size, Criterion("seconds", 0, lambda run: run.seconds))


def _breaking(name: str, n_goals: int) -> Criterion:
    def value(run: RunResult) -> float:
        """Return a number of evaluations to be ranked; infinity stands for never."""
        place: int | None = getattr(run, name)[n_goals - 1]
        return inf if place is None else float(place)

    return Criterion(f"{name}_{n_goals}", -1, value)


def _tests(
    criterion: Criterion,
    values: Mapping[str, Sequence[float]],
    pairs: Sequence[tuple[str, str]],
) -> list[PairTest]:
    signed = {name: [criterion.sign * value for value in each] for name, each in values.items()}
    ranks = [compare_ranks(signed[first], signed[second]) for first, second in pairs]
    adjusted = holm([each.p_value for each in ranks])
    found = zip(pairs, ranks, adjusted, strict=True)
    return [PairTest(criterion.name, *pair, each, p_value) for pair, each, p_value in found]


def as_json(comparison: Comparison) -> dict[str, Any]:
    """Return a comparison as values of JSON; infinity becomes ``null``."""
    return {
        "schema": SCHEMA,
        **({} if comparison.sweep is None else {"sweep": comparison.sweep.as_json()}),
        "algorithms": list(comparison.algorithms),
        "seeds": list(comparison.seeds),
        "quartiles": {
            measure: {
                name: {part: finite(value) for part, value in asdict(found).items()}
                for name, found in by_algorithm.items()
            }
            for measure, by_algorithm in comparison.quartiles.items()
        },
        "tests": [test.as_json() for test in comparison.tests],
        "runs": [asdict(run) | {"best_fitness": run.best_fitness} for run in comparison.runs],
    }


def finite(value: float) -> float | None:
    """Return a number, or ``None`` for infinity."""
    return value if isfinite(value) else None
