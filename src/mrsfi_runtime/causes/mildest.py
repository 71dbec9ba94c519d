"""Shrink weaknesses to their mildest variants, and number the weaknesses of each goal.

A mild variant has values near the true ones, and short windows. Values and windows are bisected
one after the other, while the goal breaks in several mission seeds at once. Bisection assumes that
a variant milder than one that does not break the goal does not break it either. This need not
hold, so the result is the mildest variant that was found.

``Deviation`` measures variants, ``mildest`` shrinks them. A ``GoalWeakness`` is a numbered
weakness: a goal and a set of faults that breaks it, by up to three measures.
"""

import math
from collections import Counter
from collections.abc import Callable, Generator, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import reduce
from itertools import combinations, count, groupby, product, starmap
from operator import add
from typing import TYPE_CHECKING, Any, NamedTuple, Self, TypeAlias

from mrsfi_runtime.causes.cause_set import Column, EvaluateIn
from mrsfi_runtime.causes.weakness import (
    MEASURES,
    Breaking,
    Broken,
    Known,
    Weakness,
    dated,
    faults_of,
    form,
    parts,
)
from mrsfi_runtime.engine.recording import Recording, RecordMany
from mrsfi_runtime.kernel.state import PROPERTIES
from mrsfi_runtime.model.fault_types import Mode
from mrsfi_runtime.model.faults import Specification, TimedFault, fault_ticks, touched
from mrsfi_runtime.model.mission import Mission
from mrsfi_runtime.search.space import SearchSpace

if TYPE_CHECKING:
    from mrsfi_runtime.causes.confirmation import Confirmation
    from mrsfi_runtime.causes.consequences import Monitored

N_SEEDS = 3
"""Mission seeds, the campaign's first among them, in which a variant must break the goal."""

N_STEPS = 14
"""Steps of values, and of windows, of a map."""

_N_STARTS = 5  # flown variants among which to look for one that holds in all seeds
_FINE = 16  # bisection ends when its ends differ by no more than this part
_LEAST = 0.001  # or by this share of the first error or window
_AXES = ("off", "before", "after")  # of what is bisected of a fault
_BROKEN = {
    "believed": ("is violated in belief", "violated it in belief", "violate it in belief"),
    "true": ("is violated", "violated it", "violate it"),
    "missed": ("fails", "made it fail", "make it fail"),
}


@dataclass(frozen=True, slots=True)
class Mildest:
    """The mildest variant of a weakness that was found.

    ``sentence`` describes it, and the strongest variant tried that did not break the goal; ``off``
    has the error of each fault's values. ``n_flights`` counts new flights with faults; a flight for
    several weaknesses counts for the first.
    """

    weakness: Weakness
    sentence: str
    n_flights: int
    off: tuple[str, ...] = ()

    def as_json(self) -> dict[str, Any]:
        """Return it as plain values, those of the weakness among them."""
        more = {"sentence": self.sentence, "flights": self.n_flights, "off": list(self.off)}
        return self.weakness.as_json() | more

    @classmethod
    def from_json(cls, row: Mapping[str, Any]) -> Self:
        """Return the one that plain values describe; errors as of a weakness."""
        weakness, off = Weakness.from_json(row), tuple(map(str, row["off"]))
        return cls(weakness, str(row["sentence"]), int(row["flights"]), off)


@dataclass(frozen=True, slots=True)
class Deviation:
    """Measures variants by their distance from the truth in a recorded flight without faults."""

    space: SearchSpace
    recording: Recording

    def harmless(self, timed: TimedFault) -> tuple[float, ...]:
        """Return the values with which a fault would change nothing when it begins.

        A fixed value is harmless if it is the true one. A delay, a difference or a percentage is
        harmless at 0.
        """
        fault, world = self.space.gate.pool[timed.fault], self.recording["world"]
        targets = touched(self.space.gate.mission, fault)
        if fault.kind.mode is not Mode.FIXED or not targets:
            return (0.0,) * len(timed.values)
        affected, index = targets[0]
        owners, fields = PROPERTIES[affected]
        owner = world[min(timed.start, len(world) - 1)][owners][index]
        true = tuple(float(owner[field]) for field in fields)[: len(timed.values)]
        return true + timed.values[len(true) :]

    def share(self, timed: TimedFault) -> float:
        """Return the largest error of the values, as a share of its range, to four digits."""
        bounds = self.space.candidates[timed.fault].bounds
        bounded = zip(timed.values, self.harmless(timed), bounds, strict=True)
        shares = (abs(value - true) / (b - a) for value, true, (a, b) in bounded if a < b)
        return round(max(shares, default=0.0), 4)

    def size(self, specification: Specification) -> float:
        """Return how strong a variant is: its errors, and the share of the mission it is active."""
        duration = self.space.duration
        off = reduce(add, map(self.share, specification), 0.0)  # ``sum`` depends on the Python
        return off + fault_ticks(specification, duration) / duration

    def milder(
        self, timed: TimedFault, off: float = 1.0, before: float = 1.0, after: float = 1.0
    ) -> TimedFault:
        """Return a fault with a share of its error, in the last or first share of its window."""
        length = timed.finish - timed.start
        start, finish = timed.finish - round(before * length), timed.start + round(after * length)
        there = timed._replace(start=start, finish=finish)
        candidate, values = self.space.candidates[timed.fault], []
        harmless = zip(timed.values, self.harmless(timed), self.harmless(there), strict=True)
        limits = zip(candidate.is_integer, candidate.bounds, strict=True)
        for (value, true, then), (is_whole, (low, high)) in zip(harmless, limits, strict=True):
            near = then + (value - true) * off
            values.append(min(max(float(round(near) if is_whole else f"{near:.6g}"), low), high))
        return there._replace(values=tuple(values))

    def in_words(self, timed: TimedFault) -> str:
        """Return the error of the values: ``41 off``, ``3 energy units off``, ``DELAY 9 ticks``."""
        kind, units = self.space.gate.pool[timed.fault].kind, self.space.gate.mission.units
        if kind.mode is not Mode.FIXED:
            return kind.in_words(timed.values, units)
        apart = math.dist(timed.values[:2], self.harmless(timed)[:2])
        return f"{units.quantity(apart, kind.parameters[0].range)} off"

    def error_in_words(self, timed: TimedFault) -> str:
        """Return the same inside a sentence: ``an error of 41 units``, ``DELAY 9 ticks``."""
        kind, mission = self.space.gate.pool[timed.fault].kind, self.space.gate.mission
        if kind.mode is not Mode.FIXED:
            return kind.in_words(timed.values, mission.units, 4)
        unit = " units" if kind.is_place and not mission.distance_unit else ""
        return f"an error of {self.in_words(timed).removesuffix(' off')}{unit}"


_Flights: TypeAlias = tuple[Sequence[Specification], int]  # and their mission seed
_Findings: TypeAlias = Sequence[Broken]
Walk: TypeAlias = Generator[_Flights, _Findings, tuple[Specification, int]]
"""Asks for flights, and returns a variant, and in how many mission seeds it breaks the goal."""


def mildest(
    space: SearchSpace,
    known: Known,
    found: Sequence[Weakness],
    evaluate: EvaluateIn,
    record_many: RecordMany,
    seeds: Sequence[int],
    on_progress: Callable[[int, int], None] = lambda *_: None,
) -> tuple[Mildest, ...]:
    """Return the mildest variant of each weakness, in their order.

    A variant must break the goal in all ``seeds``, while no part of it does. If no starting variant
    does, it must do so in as many of the first seeds as the best one. ``known`` and ``record_many``
    are of the first seed. ``on_progress`` receives how many bisections have ended, from 0 on, and
    how many there are.
    """
    deviation, n_ended = Deviation(space, *record_many([()])), count()
    flown = Breaking(space.gate.mission, evaluate, seeds)
    flown.known |= {(each, seeds[0]): broken for each, broken in known.flown.items()}
    most = sum(len(_AXES) * len(each.witness) for each in found)

    def end() -> None:
        on_progress(next(n_ended), most)

    end()
    walks = []
    for each in found:
        breaking = known.breaking(each.column, frozenset(each.faults))
        starts = (*sorted(breaking, key=deviation.size)[:_N_STARTS], each.witness)
        walks.append(_shrunk(deviation, starts, each.column, seeds, end))
    ended = zip(found, _side_by_side(walks, flown), strict=True)
    least = [_mildest(deviation, known, flown, each, *shrunk) for each, shrunk in ended]
    with_ticks = dated(flown.yardsticks[seeds[0]], [each.weakness for each in least], record_many)
    return tuple(replace(each, weakness=one) for each, one in zip(least, with_ticks, strict=True))


class Tried(NamedTuple):
    """A point of a map: the error of the values, the active ticks, whether the goal breaks."""

    off: float
    ticks: int
    is_broken: bool


def tried_map(
    deviation: Deviation, weakness: Weakness, evaluate: EvaluateIn, seed: int
) -> tuple[Tried, ...]:
    """Fly the witness of a weakness with shares of its error, and of its duration.

    ``off`` is the largest error of the faults, in shares of its range; 0 for faults without values.
    """
    steps = [step / N_STEPS for step in range(1, N_STEPS + 1)]
    variants = [
        tuple(deviation.milder(timed, off=off, after=after) for timed in weakness.witness)
        for off in steps
        for after in steps
    ]
    flown = Breaking(deviation.space.gate.mission, evaluate, [seed])(variants, seed)
    return tuple(
        Tried(
            max(map(deviation.share, tried)),
            fault_ticks(tried, deviation.space.duration),
            weakness.column in broken,
        )
        for tried, broken in zip(variants, flown, strict=True)
    )


def _side_by_side(
    walks: Sequence[Walk], flown: Breaking
) -> Iterator[tuple[Specification, int, int]]:
    """Yield what each walk returns, and how many new flights it asked for first."""
    ends, n_flights = {}, Counter[int]()
    asked = {place: next(walk) for place, walk in enumerate(walks)}
    while asked:
        ((seed, _),) = Counter(seed for _, seed in asked.values()).most_common(1)
        served = [place for place in asked if asked[place][1] == seed]
        first = {each: place for place in reversed(served) for each in asked[place][0]}
        new = {each: place for each, place in first.items() if (each, seed) not in flown.known}
        n_flights.update(new.values())
        flown([*new], seed)
        for place in served:
            try:
                asked[place] = walks[place].send(flown(*asked[place]))
            except StopIteration as end:
                ends[place] = end.value
                del asked[place]
    return ((*ends[place], n_flights[place]) for place in range(len(walks)))


def _n_held(
    column: Column, tried: Specification, seeds: Sequence[int]
) -> Generator[_Flights, _Findings, int]:
    """Return in how many seeds, one after the other, a variant breaks it, and no part does."""
    whole = [form(tried), *map(form, parts(tried))]
    for n_held, seed in enumerate(seeds):
        broken, *alone = yield whole, seed
        if column not in broken.difference(*alone):
            return n_held
    return len(seeds)


def _shrunk(
    deviation: Deviation,
    starts: Sequence[Specification],
    column: Column,
    seeds: Sequence[int],
    end: Callable[[], None],
) -> Walk:
    """Return the mildest variant that is reached from the best of some starts, and its seeds.

    ``end`` is called as each bisection ends.
    """
    found, n_held = starts[0], 0
    for each in starts:
        n = yield from _n_held(column, each, seeds)
        found, n_held = (each, n) if n > n_held else (found, n_held)
    least = n_held
    for place, axis in product(range(len(found)), _AXES if least else ()):
        whole, broke, kept, share = found, 1.0, 0.0, 0.0
        while broke - kept > max(broke / _FINE, _LEAST):
            milder = deviation.milder(whole[place], **{axis: share})
            tried = (*whole[:place], milder, *whole[place + 1 :])
            clashes = any(starmap(deviation.space.clash, combinations(tried, 2)))
            n = 0 if clashes else (yield from _n_held(column, tried, seeds))
            if n >= least:
                broke, found, n_held = share, tried, n
            else:
                kept = share
            share = (kept + broke) / 2 if kept else broke / 4
        end()
    return form(found), n_held


def _mildest(
    deviation: Deviation,
    known: Known,
    flown: Breaking,
    weakness: Weakness,
    shrunk: Specification,
    n_held: int,
    n_flights: int,
) -> Mildest:
    column, faults = weakness.column, frozenset(weakness.faults)
    as_flown = {form(each): each for each in known.breaking(column, faults)}
    least = replace(
        weakness,
        witness=as_flown.get(shrunk, shrunk),
        n_held=n_held,
        n_seeds=len(flown.seeds),
    )
    tried: dict[Specification, bool] = {}
    for (each, _), broken in flown.known.items():
        if faults_of(each) == faults:
            tried[each] = tried.get(each, False) or column in broken
    off = (deviation.in_words(each) if deviation.share(each) else "" for each in least.witness)
    sentence = _sentence(deviation, least, tried)
    return Mildest(least, sentence, n_flights, tuple(off))


def _sentence(deviation: Deviation, weakness: Weakness, tried: dict[Specification, bool]) -> str:
    """Describe a weakness, and the strongest variant below it that did not break the goal.

    Variants of a single fault are ordered by the error of its values, others by active ticks.
    """
    found, (goal, kind) = weakness.witness, weakness.column
    is_off = len(found) == 1 and deviation.share(found[0]) > 0.0
    units, duration = deviation.space.gate.mission.units, deviation.space.duration

    def size(each: Specification) -> float:
        return deviation.share(each[0]) if is_off else fault_ticks(each, duration)

    def lasting(each: Specification) -> str:
        return units.ticks(fault_ticks(each, duration)) + " in total" * (len(each) > 1)

    def words(each: Specification) -> str:
        return deviation.error_in_words(each[0]) if is_off else lasting(each)

    faults, are = " and ".join(weakness.faults), "is" if len(weakness.faults) == 1 else "are"
    value = f" with {words(found)}" if is_off else ""
    least = min(size(each) for each, is_broken in tried.items() if is_broken)
    kept = [each for each in tried if size(each) < least]
    breaks, broke, break_it = _BROKEN[kind]
    less = "No milder variant was tried"
    if kept:
        most = f"with up to {words(max(kept, key=size))}"
        less = f"None of {len(kept)} trials {most} {broke}"
        if len(kept) == 1:
            less = f"The only trial {most} did not {break_it}"
    return f"{goal} {breaks} when {faults} {are} active for {lasting(found)}{value}. {less}"


@dataclass(frozen=True, slots=True)
class GoalWeakness:
    """A numbered weakness, from 1: a goal, and a minimal set of the pool's faults that breaks it.

    ``by`` has a ``Weakness`` for each measure by which they break it, in the order of ``MEASURES``;
    ``mildest`` is the mildest variant by the gravest measure, if one was sought. ``elsewhere`` has
    its results in other worlds, ``monitored`` what monitors detect, if they were sought.
    """

    number: int
    goal: str
    faults: tuple[str, ...]
    by: tuple[Weakness, ...]
    mildest: Mildest | None = None
    elsewhere: "tuple[Confirmation, ...]" = ()
    monitored: "Monitored | None" = None

    @property
    def shown(self) -> Weakness:
        """The weakness by the gravest measure: missed before true, true before believed."""
        return self.by[-1]

    @property
    def measure(self) -> str:
        """The gravest measure by which the goal breaks."""
        return self.shown.column.kind

    @property
    def is_undetected(self) -> bool:
        """Whether the collective intelligence fails to detect at least one variant."""
        return self.shown.detection is not None and self.shown.detection.n_never > 0

    @property
    def is_mildest(self) -> bool:
        """Whether the mildest variant is the one that is shown."""
        return self.mildest is not None and self.mildest.weakness == self.shown

    @property
    def at_least(self) -> Self:
        """The same in its mildest variant, if one is known."""
        if self.mildest is None:
            return self
        return replace(self, by=(*self.by[:-1], self.mildest.weakness))

    def as_json(self) -> list[dict[str, Any]]:
        """Return the weakness by each measure as plain values."""
        return [{"number": self.number, **each.as_json()} for each in self.by]


def goal_weaknesses(
    weaknesses: Iterable[Weakness], mildest: Iterable[Mildest] = ()
) -> tuple[GoalWeakness, ...]:
    """Return weaknesses by goal and set of faults, numbered in the order in which they come."""

    def broken(weakness: Weakness) -> tuple[str, tuple[str, ...]]:
        return weakness.column.goal, weakness.faults

    least_of = {broken(each.weakness): each for each in mildest}
    return tuple(
        GoalWeakness(number, *cause, tuple(each), least_of.get(cause))
        for number, (cause, each) in enumerate(groupby(weaknesses, key=broken), 1)
    )


def least(weaknesses: Iterable[GoalWeakness]) -> tuple[GoalWeakness, ...]:
    """Return one for each goal: fewest faults, in truth, in most mission seeds and variants."""

    def size(each: GoalWeakness) -> tuple[int, bool, int, float]:
        shown = each.shown
        n_lost = shown.n_seeds - shown.n_held
        return len(each.faults), shown.column.kind == MEASURES[0], n_lost, -shown.share

    by_goal = groupby(weaknesses, key=lambda each: each.goal)
    return tuple(min(some, key=size).at_least for _, some in by_goal)


def gravity(mission: Mission) -> Callable[[GoalWeakness], tuple[int, int, bool, int]]:
    """Return the key by which weaknesses are sorted, the gravest first.

    Those that make a goal fail come first, then true violations. Of equal ones, the more severe
    goals, then undetected weaknesses come first.
    """
    severity = {goal.id: goal.severity for goal in mission.goals}

    def key(each: GoalWeakness) -> tuple[int, int, bool, int]:
        grave = -MEASURES.index(each.measure), -severity[each.goal]
        return *grave, not each.is_undetected, each.number

    return key
