"""What follows from weaknesses: how many there are, how likely goals break, what to do first.

``estimate`` says how many weaknesses there are, from campaigns that searched with different seeds.
Each campaign is a sample. Sets of faults that few of the samples contain show that others are
contained in none. Samples are not as independent, and sets not as alike, as the estimator assumes;
docs/find-weaknesses.md says where it errs.

``risk`` says how likely faults are to break a goal, from their likelihoods and the weaknesses
found. Faults occur independently of each other. If all faults of a minimal set occur, they break
the goal with the share of their variants, independently of other sets. ``Risk`` has a lower value,
for which only what is known counts, and an upper one, for which what is estimated counts, too.

``ladder`` says what to protect first: few elements whose faults, kept out, close all weaknesses. An
element is a robot, sensor, message or obstacle; its faults are those of ``elements_of``. A weakness
is *closed* when a fault of its set is kept out. Only weaknesses that break a goal in truth count.
``cover`` is the greedy algorithm for set cover, and ``closing`` has the flights that confirm the
result. ``Advice`` says which monitors to add first; ``causes.monitors`` finds them.

References
----------
A. Chao, "Estimating the population size for capture-recapture data with unequal catchability",
Biometrics 43, 1987: the estimator Chao2, and its log-normal interval. R. K. Colwell, "EstimateS",
user's guide, appendix B: its form corrected for bias, and the interval if no set is missing.

ISO 26262-5:2018, table 4: targets of diagnostic coverage, low, medium and high.

C. J. Clopper and E. S. Pearson, "The use of confidence or fiducial limits illustrated in the case
of the binomial", Biometrika 26, 1934: the lower end of a share.
"""

import json
import math
from collections import Counter
from collections.abc import Collection, Hashable, Iterable, Iterator, Mapping, Sequence, Set
from dataclasses import dataclass
from itertools import chain
from typing import Any, NamedTuple, Self, TypeAlias

from mrsfi_runtime.causes.mildest import GoalWeakness
from mrsfi_runtime.causes.weakness import MEASURES, FaultSet, Known, Weakness, form
from mrsfi_runtime.model.faults import FaultPool, Specification, elements_of
from mrsfi_runtime.model.mission import Mission, wilson

_Z = 1.96  # standard deviations on both sides of 95 % of a normal distribution


class Total(NamedTuple):
    """How many sets samples contain, an estimate of how many there are, and its 95 % interval."""

    n_found: int
    value: float
    low: int
    high: int

    @classmethod
    def of(cls, samples: Sequence[Set[Hashable]]) -> Self:
        """Estimate it from at least two samples."""
        n_times = Counter(chain.from_iterable(samples))
        found, by_times = len(n_times), Counter(n_times.values())
        once, twice = by_times[1], by_times[2] + 1
        part = (len(samples) - 1) / len(samples)
        missing = part * once * (once - 1) / (2 * twice)
        if missing:
            variance = missing + part**2 * once * (
                (2 * once - 1) ** 2 / (4 * twice**2)
                + once * (twice - 1) * (once - 1) ** 2 / (4 * twice**4)
            )
            off = math.exp(_Z * math.sqrt(math.log1p(variance / missing**2)))
            low, high = found + missing / off, found + missing * off
        else:
            unseen = math.exp(-n_times.total() / found) if found else 0.0
            middle, off = found / (1 - unseen), _Z * math.sqrt(found * unseen) / (1 - unseen)
            low, high = max(found, middle - off), middle + off
        return cls(found, found + missing, math.floor(low), math.ceil(high))


class Estimate(NamedTuple):
    """The number of weaknesses of a goal by some measures, and those that the first sample lacks.

    ``lacking`` are sets of sorted fault IDs, small ones first.
    """

    n_campaigns: int
    total: Total
    lacking: tuple[tuple[str, ...], ...]

    def as_json(self) -> dict[str, Any]:
        """Return it as plain values."""
        n_found, value, *interval = self.total
        counts = {"campaigns": self.n_campaigns, "found": n_found, "estimated": value}
        return counts | {"interval": interval, "lacking": [*map(list, self.lacking)]}


def estimate(
    campaigns: Sequence[Iterable[Weakness]], goal: str, measures: Collection[str] = MEASURES
) -> Estimate:
    """Estimate the number of weaknesses of a goal from those that each campaign found.

    A set does not count if another campaign found a part of it that breaks the goal by the same
    measure.
    """
    found = [
        {
            (each.column.kind, frozenset(each.faults))
            for each in some
            if each.column.goal == goal and each.column.kind in measures
        }
        for some in campaigns
    ]
    every = set[tuple[str, FaultSet]]().union(*found)
    minimal = {
        (kind, faults)
        for kind, faults in every
        if not any(kind == other and part < faults for other, part in every)
    }
    samples = [{faults for _, faults in some & minimal} for some in found]
    lacking = (tuple(sorted(each)) for each in set[FaultSet]().union(*samples) - samples[0])
    ordered = sorted(lacking, key=lambda faults: (len(faults), faults))
    return Estimate(len(samples), Total.of(samples), tuple(ordered))


Share: TypeAlias = tuple[FaultSet, float]
"""A set of faults, and the chance that it breaks a goal if its faults occur."""

_TAIL = 0.025  # of a distribution, beyond one end of a 95 % interval
_MOST_PIVOTS = 12  # faults on whose occurrence a tree is split; time doubles with each


class Risk(NamedTuple):
    """How likely a goal is to be truly violated or to fail in a mission, 0 … 1.

    ``upper`` is ``None`` without campaigns to estimate from. ``n_sets`` minimal sets are known,
    ``n_unknown`` of which have a fault without likelihood and do not count for ``lower``.
    """

    lower: float
    upper: float | None
    n_sets: int
    n_unknown: int


def cut_sets(weaknesses: Iterable[GoalWeakness], goal: str) -> list[tuple[str, ...]]:
    """Return the minimal sets of faults that truly violate a goal or make it fail, by size."""
    breaking = (each for each in weaknesses if each.goal == goal)
    real = {each.faults for each in breaking if each.shown.column.kind != MEASURES[0]}
    least = (faults for faults in real if not any({*other} < {*faults} for other in real))
    return sorted(least, key=lambda faults: (len(faults), faults))


def occurrence(pool: FaultPool, faults: Iterable[str]) -> float | None:
    """Return how likely all of some faults are to occur; ``None`` if a likelihood is unknown."""
    chances = [pool[fault].likelihood for fault in faults]
    known = [chance for chance in chances if chance is not None]
    return math.prod(known) if len(known) == len(chances) else None


def risk(pool: FaultPool, goal: str, campaigns: Sequence[Sequence[GoalWeakness]]) -> Risk | None:
    """Return the risk of a goal by what campaigns found; ``None`` if no likelihood is known.

    The lower value takes the lower ends of shares. For the upper one, every variant breaks the
    goal, sets are independent, and there are as many as the upper end of the estimate says: those
    of unknown likelihood, and those not found, are as likely as the mean of the others.
    """
    every = [each for some in campaigns for each in some if each.goal == goal]
    shares = dict[FaultSet, float]()
    for faults in cut_sets(every, goal):
        by = (one for each in every if each.faults == faults for one in each.by)
        truly = (one for one in by if one.column.kind != MEASURES[0])
        shares[frozenset(faults)] = max(map(_least_share, truly))
    chances = {faults: occurrence(pool, faults) for faults in shares}
    known = {faults: chance for faults, chance in chances.items() if chance is not None}
    if not known:
        return None
    likelihoods = {fault.id: fault.likelihood or 0.0 for fault in pool}
    lower = 1.0 - kept([(faults, shares[faults]) for faults in known], likelihoods)
    upper = None
    if len(campaigns) > 1:
        found = [[one for each in some for one in each.by] for some in campaigns]
        n_others = max(len(shares), estimate(found, goal, MEASURES[1:]).total.high) - len(known)
        mean = math.fsum(known.values()) / len(known)
        upper = 1.0 - math.prod(1.0 - each for each in known.values()) * (1.0 - mean) ** n_others
    return Risk(lower, upper, len(shares), len(shares) - len(known))


def risks(
    pool: FaultPool, goals: Iterable[str], campaigns: Sequence[Sequence[GoalWeakness]]
) -> dict[str, Risk]:
    """Return the risk of each of some goals, without those for which no likelihood is known."""
    found = {goal: risk(pool, goal, campaigns) for goal in goals}
    return {goal: each for goal, each in found.items() if each}


def _least_share(weakness: Weakness) -> float:
    """Return the lower end of a weakness's share (of several faults, Clopper and Pearson's).

    The variants of several faults were chosen by the search, which favours those that break.
    """
    if weakness.weighted is not None:
        return weakness.weighted.low
    n, low, high = weakness.n_tried, 0.0, 1.0
    while high - low > 1e-6:
        share = (low + high) / 2
        ways = (
            math.comb(n, k) * share**k * (1 - share) ** (n - k)
            for k in range(weakness.n_broken, n + 1)
        )
        low, high = (share, high) if math.fsum(ways) < _TAIL else (low, share)
    return low


def kept(
    sets: Sequence[Share], likelihoods: Mapping[str, float], n_pivots: int = _MOST_PIVOTS
) -> float:
    """Return the chance that no set breaks the goal, by a fault that several sets have.

    If many sets share faults, it is an upper bound.
    """

    def chance(each: Share) -> float:
        return each[1] * math.prod(likelihoods[fault] for fault in each[0])

    n_times = Counter(chain.from_iterable(faults for faults, _ in sets))
    fault, n_most = max(n_times.items(), key=lambda each: (each[1], each[0]), default=("", 0))
    if n_most > 1 and n_pivots:
        likelihood = likelihoods[fault]
        occurs = [(faults - {fault}, share) for faults, share in sets]
        absent = [each for each in sets if fault not in each[0]]
        with_it, without = (kept(some, likelihoods, n_pivots - 1) for some in (occurs, absent))
        return likelihood * with_it + (1.0 - likelihood) * without
    taken: set[str] = set()
    none = 1.0
    for each in sorted(sets, key=chance, reverse=True):
        if taken.isdisjoint(each[0]):  # sets without a common fault are independent
            taken |= each[0]
            none *= 1.0 - chance(each)
    return none


@dataclass(frozen=True, slots=True)
class Step:
    """An element to protect after those of the steps before, its faults, and what it closes."""

    element: str
    faults: FaultSet
    closed: tuple[GoalWeakness, ...]


def cover(elements: Mapping[str, FaultSet], sets: Sequence[FaultSet]) -> list[str]:
    """Return elements, by their faults, until each set has a fault of one of them.

    Next is the element that closes most of the sets left; of equal ones, that with fewest faults,
    then the first. Each set must have a fault of an element.
    """
    chosen = []
    while sets:
        n_closed = {
            element: sum(not faults.isdisjoint(each) for each in sets)
            for element, faults in elements.items()
        }
        best = max(elements, key=lambda each: (n_closed[each], -len(elements[each])))
        chosen.append(best)
        sets = [each for each in sets if elements[best].isdisjoint(each)]
    return chosen


def ladder(mission: Mission, pool: FaultPool, found: Iterable[GoalWeakness]) -> tuple[Step, ...]:
    """Return the elements to protect, one after the other, until all weaknesses are closed."""
    left = [each for each in found if each.shown.column.kind != MEASURES[0]]
    struck = {fault.id: elements_of(mission, fault) for fault in pool}
    elements = {
        element: frozenset(fault for fault in struck if element in struck[fault])
        for element in mission.elements
    }
    steps = []
    for element in cover(elements, [frozenset(each.faults) for each in left]):
        faults = elements[element]
        closed = tuple(each for each in left if not faults.isdisjoint(each.faults))
        steps.append(Step(element, faults, closed))
        left = [each for each in left if each not in closed]
    return tuple(steps)


def closing(steps: Iterable[Step]) -> Iterator[tuple[GoalWeakness, Specification]]:
    """Yield each weakness, and its variant without the faults that its step has kept out."""
    kept_out: set[str] = set()
    for step in steps:
        kept_out |= step.faults
        for weakness in step.closed:
            witness = weakness.shown.witness
            yield weakness, tuple(each for each in witness if each.fault not in kept_out)


def confirmed(steps: Iterable[Step], known: Known) -> tuple[int, Mapping[int, bool]]:
    """Return how many flights of ``closing`` are known, and which weaknesses are gone in theirs.

    Weaknesses are given by number, without those whose flight is not known.
    """
    pairs = [(weakness, form(rest)) for weakness, rest in closing(steps)]
    flown = [(weakness, rest) for weakness, rest in pairs if rest in known.flown]
    gone = {each.number: each.shown.column not in known.flown[rest] for each, rest in flown}
    return len({rest for _, rest in flown}), gone


STAGES = ("in time", "before the goal fails", "later", "never")
"""When it is detected that a goal is broken, the best first."""


class Coverage(NamedTuple):
    """Shares of the weight of variants by the ``STAGES``, and the 95 % interval of those in time.

    The interval is Wilson's. Its number of trials is Kish's, so that each weighs the same.
    """

    in_time: float
    before_failure: float
    later: float
    never: float
    low: float
    high: float

    @classmethod
    def of(cls, stages: Sequence[tuple[int, float]]) -> Self:
        """Return the coverage of at least one variant, each with its stage and its weight."""
        total = math.fsum(weight for _, weight in stages)
        n = total**2 / math.fsum(weight**2 for _, weight in stages)
        shares = [
            math.fsum(weight for stage, weight in stages if stage == place) / total
            for place in range(len(STAGES))
        ]
        return cls(*(*shares, *wilson(n * shares[0], n)))

    @property
    def level(self) -> str:
        """The class of ISO 26262 that the share in time reaches."""
        levels = ((0.99, "high"), (0.9, "medium"), (0.6, "low"))
        return next((name for least, name in levels if self.in_time >= least), "none")


class Addition(NamedTuple):
    """A monitor to add to those before, the elements at which it gains, and the coverage then."""

    monitor: str
    elements: tuple[str, ...]
    coverage: Coverage


class Monitored(NamedTuple):
    """The first monitor that helps with a weakness, and variants detected in time with all."""

    monitor: str
    n_in_time: int
    n_variants: int


class Advice(NamedTuple):
    """The monitors to add, as a record keeps them, and what they do for each weakness.

    ``before`` is the coverage without them, ``watched`` has weaknesses by number. They raise false
    alarms in ``n_false`` of ``n_fresh`` mission seeds.
    """

    n_evaluations: int
    before: Coverage
    steps: tuple[Addition, ...]
    watched: Mapping[int, Monitored]
    n_false: int
    n_fresh: int

    def text(self) -> str:
        """Return it as JSON."""
        return json.dumps(self)

    @classmethod
    def read(cls, text: str) -> Self:
        """Return what was kept as a text."""
        n_evaluations, before, steps, watched, n_false, n_fresh = json.loads(text)
        return cls(
            n_evaluations,
            Coverage(*before),
            tuple(Addition(name, tuple(some), Coverage(*then)) for name, some, then in steps),
            {int(number): Monitored(*each) for number, each in watched.items()},
            n_false,
            n_fresh,
        )
