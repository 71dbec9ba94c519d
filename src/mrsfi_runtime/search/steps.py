"""Small changes of a fault specification: Gaussian steps, jumps to landmarks, longer windows.

Each takes a specification and returns another one that keeps the restriction; what went in
stays as it was. ``guided`` chooses among them; ``creep`` is a mutation of all three.
"""

from collections.abc import Callable, Mapping
from functools import partial
from random import Random
from types import MappingProxyType
from typing import TypeAlias

from mrsfi_runtime.model.faults import Specification, TimedFault
from mrsfi_runtime.search.space import SearchSpace, Window, random_window, within
from mrsfi_runtime.search.variation import Mutation, freely_mutated, mutated, transformed

Step: TypeAlias = Callable[[SearchSpace, Specification, Random], Specification]
"""From a specification another one of at most the same size."""

_SPREAD = 0.1  # standard deviation of a Gaussian step, as a share of the range
_MOST_TAKEN = 3  # faults of a donor
_IN_PLACE = 0.5  # chance of a jump to where another fault of the specification puts something


def swapped(space: SearchSpace, specification: Specification, rng: Random) -> Specification:
    """Put a fault of the pool in the place of one, wherever it fits longest."""
    if not specification:
        return specification
    kept = list(specification)
    kept.pop(rng.randrange(len(kept)))
    return filled(space, tuple(kept), len(specification), rng)


def forced(space: SearchSpace, specification: Specification, rng: Random) -> Specification:
    """Have a fault of the pool active all the time; what conflicts with it leaves."""
    fault = rng.choice(tuple(space.candidates))
    values = _landmark(space, fault, specification, rng)
    trigger = space.candidates[fault].drawn_trigger(rng)
    timed = TimedFault(fault, 0, space.duration - 1, values, trigger)
    kept = [other for other in specification if not space.clash(timed, other)]
    if len(kept) == len(specification) and kept:
        kept.pop(rng.randrange(len(kept)))
    return space.ordered([timed, *kept])


def dropped(space: SearchSpace, specification: Specification, rng: Random) -> Specification:
    """Leave one fault out, unless it is the only one; others stretch into its place."""
    if len(specification) < 2:
        return specification
    place = rng.randrange(len(specification))
    left = specification[:place] + specification[place + 1 :]
    conflicts = space.candidates[specification[place].fault].conflicts
    for timed in left:
        if timed.fault in conflicts:
            others = [other for other in left if other != timed]
            left = space.ordered([*others, _wide(space, timed, tuple(others), rng)])
    return left


def resized(
    space: SearchSpace,
    specification: Specification,
    rng: Random,
    share: float,
    *,
    mutation: Mutation,
    n_most: int,
) -> Specification:
    """Mutate, and leave a fault out, add one up to a most, or do neither, equally often."""
    changed = mutation(space, specification, rng, share)
    difference = rng.choice((-1, 0, 1))
    if difference < 0:
        return dropped(space, changed, rng)
    return filled(space, changed, min(n_most, len(changed) + difference), rng)


def grafted(
    space: SearchSpace, specification: Specification, donor: Specification, rng: Random
) -> Specification:
    """Take over a few faults of a donor; what conflicts with them leaves, then others at random.

    What comes out is at most of the size of the larger one.
    """
    taken = rng.sample(donor, min(len(donor), rng.randint(1, _MOST_TAKEN)))
    kept = [
        timed for timed in specification if not any(space.clash(timed, graft) for graft in taken)
    ]
    while len(kept) + len(taken) > max(len(specification), len(donor)):
        kept.pop(rng.randrange(len(kept)))
    return space.ordered([*taken, *kept])


def filled(
    space: SearchSpace, specification: Specification, n_faults: int, rng: Random
) -> Specification:
    """Add faults of the pool up to a number, as long as there is room, in longest free windows."""
    placed = list(specification)
    candidates = list(space.candidates)
    while candidates and len(placed) < n_faults:
        fault = candidates.pop(rng.randrange(len(candidates)))
        free = space.free_windows(fault, placed)
        if free:
            start, finish = max(free, key=lambda window: window[1] - window[0])
            values = _landmark(space, fault, tuple(placed), rng)
            trigger = space.candidates[fault].drawn_trigger(rng)
            placed.append(TimedFault(fault, start, finish, values, trigger))
    return space.ordered(placed)


def crept(
    space: SearchSpace, specification: Specification, rng: Random, share: float = 0.5
) -> Specification:
    """Mutate by Gaussian steps, jumps and wider windows in place of values drawn anew."""
    faults = list(specification)
    for place, timed in enumerate(faults):
        if rng.random() < share:
            change = rng.choice((_wide, _shifted, _jumped))
            others = tuple(faults[:place] + faults[place + 1 :])
            faults[place] = change(space, timed, others, rng)
    return space.ordered(faults)


_Change: TypeAlias = Callable[[SearchSpace, TimedFault, Specification, Random], TimedFault]


def _changed(
    change: _Change, space: SearchSpace, specification: Specification, rng: Random
) -> Specification:
    if not specification:
        return specification
    place = rng.randrange(len(specification))
    others = specification[:place] + specification[place + 1 :]
    return space.ordered([*others, change(space, specification[place], others, rng)])


def _room(space: SearchSpace, timed: TimedFault, others: Specification) -> Window:
    """Return the free window that a placed fault lies in."""
    free = space.free_windows(timed.fault, others)
    return next(window for window in free if window[0] <= timed.start <= window[1])


def _wide(
    space: SearchSpace,
    timed: TimedFault,
    others: Specification,
    rng: Random,  # noqa: ARG001 - _Change
) -> TimedFault:
    start, finish = _room(space, timed, others)
    return timed._replace(start=start, finish=finish)


def _shifted(
    space: SearchSpace, timed: TimedFault, others: Specification, rng: Random
) -> TimedFault:
    first, last = _room(space, timed, others)
    ticks = (
        min(last, max(first, round(rng.gauss(tick, _SPREAD * space.duration))))
        for tick in (timed.start, timed.finish)
    )
    start, finish = sorted(ticks)

    def stepped(value: float, low: float, high: float, is_integer: bool) -> float:
        step = rng.gauss(value, _SPREAD * (high - low))
        return min(high, max(low, float(round(step)) if is_integer else step))

    values = space.candidates[timed.fault].changed(timed.values, stepped)
    return timed._replace(start=start, finish=finish, values=values)


def _redrawn(
    space: SearchSpace, timed: TimedFault, others: Specification, rng: Random
) -> TimedFault:
    start, finish = random_window(space.free_windows(timed.fault, others), rng)
    trigger = space.candidates[timed.fault].drawn_trigger(rng)
    return timed._replace(start=start, finish=finish, trigger=trigger)


def _jumped(
    space: SearchSpace, timed: TimedFault, others: Specification, rng: Random
) -> TimedFault:
    values = _landmark(space, timed.fault, others, rng)
    return timed._replace(values=values, trigger=space.candidates[timed.fault].drawn_trigger(rng))


def _landmark(
    space: SearchSpace, fault: str, others: Specification, rng: Random
) -> tuple[float, ...]:
    """Draw values that mean something in the mission, or in the specification."""
    candidate = space.candidates[fault]
    if candidate.is_place and rng.random() < _IN_PLACE:
        places = [
            (*other.values[:2], *candidate.values[2:])
            for other in others
            if space.candidates[other.fault].is_place
            and all(map(within, other.values[:2], candidate.bounds[:2]))
        ]
        if places:
            return rng.choice(places)
    return rng.choice(candidate.landmarks)


widened: Step = partial(_changed, _wide)
"""Stretch the window of one fault as far as the others let it."""

shifted: Step = partial(_changed, _shifted)
"""Move the window and values of one fault by a Gaussian step."""

redrawn: Step = partial(_changed, _redrawn)
"""Draw the window of one fault anew, and its trigger."""

jumped: Step = partial(_changed, _jumped)
"""Let the values of one fault jump to a landmark, or to the place of another fault, and its trigger
to any."""

STEPS: tuple[Step, ...] = (widened, shifted, redrawn, jumped, swapped, forced, dropped)
"""All steps."""

MUTATIONS: Mapping[str, Mutation] = MappingProxyType(
    {"redraw": mutated, "creep": crept, "free": freely_mutated, "transform": transformed}
)
"""Mutations by their name in a campaign file."""
