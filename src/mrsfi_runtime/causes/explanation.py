"""Explain one specification: cause sets, labels, shares and the simplest variant.

``explain`` calls the parts in the order in which they are flown; each is a function below it. All
parts share the same ``Flights``, which fly no specification twice.

References
----------
L. S. Shapley, "A Value for n-Person Games", Annals of Mathematics Studies 28, 1953. J. Castro,
D. Gómez and J. Tejada, "Polynomial Calculation of the Shapley Value Based on Sampling", Computers
and Operations Research 36, 2009.
"""

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from fractions import Fraction
from itertools import combinations, groupby
from operator import mul, sub
from random import Random
from statistics import stdev

from mrsfi_runtime.causes.cause_set import Counts, Flights, Places, Question, chosen, floor, without
from mrsfi_runtime.causes.chain import Cause, find_cause
from mrsfi_runtime.engine.flights import Engine
from mrsfi_runtime.model.faults import Fault, FaultPool, Specification, TimedFault, value_bounds
from mrsfi_runtime.model.mission import Mission, Outcome

N_EXACT = 10
"""Number of faults up to which every subset is flown: 1,024 subsets."""

N_PERMUTATIONS = 100
"""Orders in which more faults than that join."""

BYSTANDER = "bystander"


@dataclass(frozen=True, slots=True)
class GoalCauses:
    """The cause of a goal's violations: its cause set, and a label for every fault.

    A fault of the set is ``sole`` if it is sufficient alone, else ``joint``. Of the other faults, a
    ``redundant`` one can replace a member; without a ``masking`` one, a count of the goal is
    higher; a ``lesser`` one breaks the goal alone, but other faults break it more or hide it. All
    others are ``bystander`` faults.
    """

    goal: str
    places: Places
    labels: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Attribution:
    """Shares of faults in counts, in ticks, shape ``(n_faults, n_columns)``.

    Each column of ``shares`` sums to the difference of the counts with all faults and with none.
    ``margins`` are half-widths of the 95 % confidence intervals; ``None`` if shares are exact.
    """

    shares: tuple[tuple[Fraction, ...], ...]
    margins: tuple[tuple[float, ...], ...] | None


@dataclass(frozen=True, slots=True)
class Explanation:
    """Why a specification breaks goals.

    ``simplest`` is the simplest variant of the cause set, flown in the first mission seed.
    ``minima`` are the different sets that shuffled orders gave. ``alone`` and ``left_out`` are
    counts under each fault alone, and under all others. ``n_flown`` counts flights by part.
    """

    cause: Cause
    simplest: Specification
    simplest_counts: Counts
    simplest_outcome: Outcome
    minima: tuple[Places, ...]
    goals: tuple[GoalCauses, ...]
    alone: tuple[Counts, ...]
    left_out: tuple[Counts, ...]
    attribution: Attribution
    n_flown: Mapping[str, int]


def explain(
    flights: Flights, engine: Engine, specification: Specification, keep: float
) -> Explanation | None:
    """Explain why a specification breaks goals; ``None`` and errors are as of ``find_cause``."""
    cause = find_cause(flights, engine, specification, keep)
    if cause is None:
        return None
    n, columns, counts = len(specification), flights.columns, cause.counts
    with flights.on("other orders"):
        minima = Question(flights, specification, floor(counts, keep, range(len(columns)))).minima()
    with flights.on("each fault alone, and left out"):
        alone = tuple((fault,) for fault in specification)
        left_out = tuple(without(specification, place) for place in range(n))
        flights.fly((*alone, *left_out))
    with flights.on("cause set and labels of each goal"):
        goals = tuple(
            goal_causes(Question(flights, specification, floor(counts, keep, places)), goal)
            for goal, places in groupby(range(len(columns)), key=lambda k: columns[k].goal)
        )
    with flights.on("attribution"):
        attribution = attribute(flights, cause.faults)
    with flights.on("simplest form"):
        simple = simplest(flights, engine.code.mission, engine.code.pool, cause.faults)
    return Explanation(
        cause=cause,
        simplest=simple,
        simplest_counts=flights.counts(simple),
        simplest_outcome=flights.outcome(simple),
        minima=minima,
        goals=goals,
        alone=tuple(map(flights.counts, alone)),
        left_out=tuple(map(flights.counts, left_out)),
        attribution=attribution,
        n_flown=dict(flights.n_flown),
    )


def goal_causes(question: Question, goal: str) -> GoalCauses:
    """Return the cause set of one goal, by its counts alone, and a label for every fault.

    The set of a goal without violations is empty. Then only a fault that hides violations, or would
    cause some alone, is more than a bystander.
    """
    whole = question.specification
    everyone = range(len(whole))
    places = question.minimum()
    others = [place for place in everyone if place not in places]
    question.flights.fly(
        chosen(whole, swapped) for other in others for swapped in _swaps(places, other)
    )
    labels = {place: "sole" if question.is_kept_by((place,)) else "joint" for place in places}
    for other in others:
        if any(map(question.is_kept_by, _swaps(places, other))):
            labels[other] = "redundant"
        elif _rises(question, goal, whole, without(whole, other), Fraction("1.05")):
            labels[other] = "masking"
        elif _rises(question, goal, (), (whole[other],), Fraction(1)):
            labels[other] = "lesser"
        else:
            labels[other] = BYSTANDER
    return GoalCauses(goal, places, tuple(labels[place] for place in everyone))


def _swaps(places: Places, other: int) -> Iterator[tuple[int, ...]]:
    return ((*(place for place in places if place != member), other) for member in places)


def _rises(
    question: Question, goal: str, first: Specification, second: Specification, by: Fraction
) -> bool:
    """Return whether a count of a goal is higher in the second flight by more than a factor."""
    flights = question.flights
    found = zip(flights.columns, flights.counts(first), flights.counts(second), strict=True)
    return any(after > by * count for column, count, after in found if column.goal == goal)


def simplest(
    flights: Flights, mission: Mission, pool: FaultPool, specification: Specification
) -> Specification:
    """Return a cause set with shorter windows and simpler values that keeps its counts.

    For each fault, the window is cut from its start, then from its finish, in steps that begin with
    half of it. Then each value becomes the first of these that keeps the counts: the pool's value,
    a bound, the value in one, two or three digits.
    """
    columns = range(len(flights.columns))
    least = floor(flights.counts(specification), 0.99, columns)
    found = [*specification]
    for place, timed in enumerate(specification):

        def is_kept(tried: TimedFault, place: int = place) -> bool:
            counts = flights.counts((*found[:place], tried, *found[place + 1 :]))
            return all(counts[k] >= count for k, count in least.items())

        found[place] = _cut(timed, mission.duration, is_kept)
        found[place] = _plain(found[place], mission, pool[timed.fault], is_kept)
    return tuple(found)


def _cut(timed: TimedFault, duration: int, is_kept: Callable[[TimedFault], bool]) -> TimedFault:
    timed = timed._replace(finish=max(timed.start, min(timed.finish, duration - 1)))
    for first, last in ((1, 0), (0, 1)):
        step = (timed.finish - timed.start + 1) // 2
        while step:
            tried = timed._replace(
                start=timed.start + first * step, finish=timed.finish - last * step
            )
            if tried.start <= tried.finish and is_kept(tried):
                timed = tried
            else:
                step //= 2
    return timed


def _plain(
    timed: TimedFault, mission: Mission, fault: Fault, is_kept: Callable[[TimedFault], bool]
) -> TimedFault:
    for k, (low, high) in enumerate(value_bounds(mission, fault)):
        rounded = (float(f"{timed.values[k]:.{digits}g}") for digits in (1, 2, 3))
        inside = [value for value in rounded if low <= value <= high]
        for value in (fault.values[k], low, high, *inside):
            values = (*timed.values[:k], value, *timed.values[k + 1 :])
            tried = timed._replace(values=values)
            if value == timed.values[k] or is_kept(tried):
                timed = tried
                break
    return timed


def attribute(flights: Flights, specification: Specification) -> Attribution:
    """Return how much of each count is due to each fault of a specification: Shapley values.

    A share is the mean increase of the count when the fault joins those before it, over all orders
    of joining. Beyond ``N_EXACT`` faults, it is over ``N_PERMUTATIONS`` random orders, the same in
    every call.
    """
    joined = [
        [(n, chosen(specification, some), chosen(specification, (*some, k))) for n, some in before]
        for k, before in enumerate(_joined(len(specification)))
    ]
    flights.fly(each for pairs in joined for _, *pair in pairs for each in pair)
    shares, margins = [], []
    for pairs in joined:
        weights = [n_orders for n_orders, _, _ in pairs]
        added = (map(sub, flights.counts(more), flights.counts(less)) for _, less, more in pairs)
        columns = [*zip(*added, strict=True)]
        sums = (sum(map(mul, weights, column)) for column in columns)
        shares.append(tuple(Fraction(each, sum(weights)) for each in sums))
        if len(joined) > N_EXACT:
            scale = 1.96 / math.sqrt(N_PERMUTATIONS)  # 95 % of a normal distribution
            margins.append(tuple(scale * stdev(column) for column in columns))
    return Attribution(tuple(shares), tuple(margins) or None)


def _joined(n: int) -> list[list[tuple[int, Places]]]:
    """Return for each of ``n`` faults the sets before it when it joins, with their weights."""
    everyone = range(n)
    if n > N_EXACT:
        random = Random(1)
        orders = [tuple(random.sample(everyone, n)) for _ in range(N_PERMUTATIONS)]
        return [[(1, order[: order.index(place)]) for order in orders] for place in everyone]
    weights = [math.factorial(size) * math.factorial(n - size - 1) for size in everyone]
    others = ([other for other in everyone if other != place] for place in everyone)
    return [
        [(weights[size], before) for size in everyone for before in combinations(some, size)]
        for some in others
    ]
