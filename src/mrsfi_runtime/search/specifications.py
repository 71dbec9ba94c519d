"""Random fault specifications, and how many faults they have.

References
----------
Source paper, section III-E a).
"""

from collections.abc import Callable, Sequence
from random import Random

from mrsfi_runtime.model.faults import Specification, TimedFault
from mrsfi_runtime.record.settings import CampaignSettings
from mrsfi_runtime.search.space import Candidate, SearchSpace, Window, random_window
from mrsfi_runtime.search.variation import random_values


def first_size(settings: CampaignSettings, rng: Random) -> int:
    """Return how many timed faults a specification of the first population is to have.

    All that the settings allow, as in the paper; if few are sought, from 1 on as many as drawn.
    """
    return rng.randint(1, settings.faults) if settings.minimise else settings.faults


def random_specification(space: SearchSpace, n_faults: int, rng: Random) -> Specification:
    """Draw timed faults from the pool, no two conflicting ones overlapping.

    Each fault is drawn with replacement, its window among those that earlier ones leave free, and
    its trigger, if the pool has any; it keeps the pool's values. The paper's lists always hold 20;
    so that there are as many as wanted, at least one, a window drawn earlier is cut short when no
    fault has a free tick left. Fewer come only if the mission is too short: every window is then
    one tick.
    """
    placed: list[TimedFault] = []
    candidates = list(space.candidates)
    while len(placed) < n_faults:
        if not candidates:
            if not _cut_one_short(placed, rng):
                break
            candidates = list(space.candidates)
        fault = rng.choice(candidates)
        free = space.free_windows(fault, placed)
        if free:
            start, finish = random_window(free, rng)
            candidate = space.candidates[fault]
            trigger = candidate.drawn_trigger(rng)
            placed.append(TimedFault(fault, start, finish, candidate.values, trigger))
        else:
            candidates.remove(fault)
    return space.ordered(placed)


def varied_fault(space: SearchSpace, fault: str, free: Sequence[Window], rng: Random) -> TimedFault:
    """Draw a form of a fault: values of one of three kinds, in the widest or a random window.

    What it waits for is drawn last, if the pool has triggers.
    """
    candidate = space.candidates[fault]
    values = rng.choice(_VALUES)(candidate, rng)
    is_wide = rng.random() < 0.5
    window = max(free, key=lambda each: each[1] - each[0]) if is_wide else random_window(free, rng)
    return TimedFault(fault, *window, values, candidate.drawn_trigger(rng))


_VALUES: tuple[Callable[[Candidate, Random], tuple[float, ...]], ...] = (
    lambda candidate, _: candidate.values,
    lambda candidate, rng: rng.choice(candidate.landmarks),
    lambda candidate, rng: random_values(candidate, candidate.values, rng),
)


def varied_specification(
    space: SearchSpace,
    n_faults: int,
    rng: Random,
    is_allowed: Callable[[frozenset[str]], bool],
) -> Specification:
    """Draw different faults of the pool, each in one of its forms, as long as others may join."""
    placed: list[TimedFault] = []
    for fault in rng.sample([*space.candidates], len(space.candidates)):
        if len(placed) == n_faults:
            break
        free = space.free_windows(fault, placed)
        if free and is_allowed(frozenset((fault, *(timed.fault for timed in placed)))):
            placed.append(varied_fault(space, fault, free, rng))
    return space.ordered(placed)


def _cut_one_short(placed: list[TimedFault], rng: Random) -> bool:
    """Shorten one window of more than one tick; return whether there was any."""
    long = [place for place, timed in enumerate(placed) if timed.finish > timed.start]
    if not long:
        return False
    place = rng.choice(long)
    timed = placed[place]
    placed[place] = timed._replace(finish=rng.randint(timed.start, timed.finish - 1))
    return True
