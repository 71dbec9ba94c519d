"""Mutation and crossover of fault specifications under the no-overlap restriction.

All are functions of their arguments and the random generator: a specification goes in,
another comes out, and what went in stays as it was. The paper's keep the restriction at every
step; the free ones ask for whatever they draw, and have it repaired.

References
----------
Source paper, sections III-E b) and c), VI a); of the free ones, section VII.
"""

from collections.abc import Callable, Container, Iterable, Mapping, Sequence
from itertools import combinations
from operator import itemgetter
from random import Random
from types import MappingProxyType
from typing import TypeAlias

from mrsfi_runtime.model.faults import Specification, TimedFault
from mrsfi_runtime.search.space import Candidate, SearchSpace, Window, random_window

Mutation: TypeAlias = Callable[[SearchSpace, Specification, Random, float], Specification]
"""From a specification, with the chance of each of its faults to change, another one."""

Crossover: TypeAlias = Callable[
    [SearchSpace, Specification, Specification, Random], tuple[Specification, Specification]
]
"""From two specifications two others."""

Block: TypeAlias = tuple[tuple[int, ...], tuple[int, ...]]
"""Places in two specifications of faults that can only change sides together."""


def mutated(
    space: SearchSpace, specification: Specification, rng: Random, share: float = 0.5
) -> Specification:
    """Draw start, finish, values and trigger of timed faults anew, each with a chance of ``share``.

    The paper names no chance per fault; one half is ours. A new window is drawn among those that
    the other faults leave free, new values within the bounds of the model.
    """
    faults = list(specification)
    for place, timed in enumerate(faults):
        if rng.random() < share:
            free = space.free_windows(timed.fault, faults[:place] + faults[place + 1 :])
            start, finish = random_window(free, rng)
            candidate = space.candidates[timed.fault]
            values = random_values(candidate, timed.values, rng)
            trigger = candidate.drawn_trigger(rng)
            faults[place] = TimedFault(timed.fault, start, finish, values, trigger)
    return space.ordered(faults)


def random_values(
    candidate: Candidate, values: tuple[float, ...], rng: Random
) -> tuple[float, ...]:
    """Draw the values that evolve anew within their bounds; keep the others."""

    def drawn(_: float, low: float, high: float, is_integer: bool) -> float:
        if is_integer:
            return float(rng.randint(int(low), int(high)))
        return min(high, max(low, rng.uniform(low, high)))  # rounding may leave the bounds

    return candidate.changed(values, drawn)


def crossed(
    space: SearchSpace, first: Specification, second: Specification, rng: Random
) -> tuple[Specification, Specification]:
    """Exchange faults between two specifications.

    The number to exchange is drawn from 1 to half the size of the smaller one, and what
    comes nearest to it is exchanged. Both stay as they are only if there is no exchange
    that the restriction, the half and the sizes allow.

    Faults that clash across the two specifications can only change sides together. They
    form blocks, and every exchange that keeps the restriction consists of whole blocks,
    so blocks that add up to an allowed exchange are found if there are any.

    The paper tolerates that individuals become unequal in size. Here as many faults leave
    as arrive, and of two unequal ones neither grows beyond the larger: more faults mean
    more violations, so sizes that may grow would be evolved instead of faults.
    """
    half = min(len(first), len(second)) // 2
    blocks = exchangeable_blocks(space, first, second)
    if not half or not blocks:
        return first, second
    wanted = rng.randint(1, half)
    rng.shuffle(blocks)
    larger = max(len(first), len(second))
    combined = {
        (n_leave, n_arrive): chosen
        for (n_leave, n_arrive), chosen in _combined(blocks, half, wanted).items()
        if len(first) - n_leave + n_arrive <= larger and len(second) - n_arrive + n_leave <= larger
    }
    if not combined:
        return first, second
    nearest = min(combined, key=lambda sizes: (abs(max(sizes) - wanted), max(sizes), sizes))
    leave = {first[place] for number in combined[nearest] for place in blocks[number][0]}
    arrive = {second[place] for number in combined[nearest] for place in blocks[number][1]}
    return (
        space.ordered((set(first) - leave) | arrive),
        space.ordered((set(second) - arrive) | leave),
    )


def exchangeable_blocks(
    space: SearchSpace, first: Specification, second: Specification
) -> list[Block]:
    """Return the smallest groups of faults of two specifications that can change sides.

    A fault that both have is left out: to exchange it would change nothing.
    """
    n_first = len(first)
    neighbours: list[list[int]] = [[] for _ in range(n_first + len(second))]
    places: dict[str, list[int]] = {}  # in the second, of each fault
    for place, theirs in enumerate(second):
        places.setdefault(theirs.fault, []).append(place)
    for i, mine in enumerate(first):
        for fault in space.candidates[mine.fault].conflicts:
            for place in places.get(fault, ()):
                if space.clash(mine, second[place]):
                    neighbours[i].append(n_first + place)
                    neighbours[n_first + place].append(i)
    blocks = []
    shared = set(first) & set(second)
    for group in _connected(neighbours):
        mine_places = tuple(place for place in group if place < n_first)
        their_places = tuple(place - n_first for place in group if place >= n_first)
        if not mine_places or first[mine_places[0]] not in shared:
            blocks.append((mine_places, their_places))
    return blocks


def _connected(neighbours: Sequence[Sequence[int]]) -> Iterable[list[int]]:
    """Yield the connected groups of a graph, members and groups in ascending order."""
    seen: set[int] = set()
    for root in range(len(neighbours)):
        if root in seen:
            continue
        seen.add(root)
        group = [root]
        for member in group:
            for other in neighbours[member]:
                if other not in seen:
                    seen.add(other)
                    group.append(other)
        yield sorted(group)


def _combined(
    blocks: Sequence[Block], limit: int, wanted: int
) -> dict[tuple[int, int], tuple[int, ...]]:
    """Return, for the numbers of faults that blocks add up to, one choice of blocks each.

    Keys count the faults that leave the first and the second specification, each at most
    ``limit`` and not both 0. All that are possible are there, unless ``wanted`` of both
    came up: then the search for others ends.
    """
    found: dict[tuple[int, int], tuple[int, ...]] = {(0, 0): ()}
    for number, (leave, arrive) in enumerate(blocks):
        if (wanted, wanted) in found:
            break
        for (n_leave, n_arrive), chosen in list(found.items()):
            sizes = (n_leave + len(leave), n_arrive + len(arrive))
            if sizes not in found and sizes[0] <= limit and sizes[1] <= limit:
                found[sizes] = (*chosen, number)
    del found[0, 0]
    return found


def repaired(space: SearchSpace, faults: Iterable[TimedFault], rng: Random) -> Specification:
    """Cut the windows of conflicting faults until none overlap; move what would vanish.

    Each fault keeps one tick of its window, those of the shortest windows drawn first. Between the
    ticks of two that conflict and overlap lies a cut, drawn from where they do. A fault whose
    ticks others keep moves to the nearest one that is free; it vanishes only if others keep every
    tick of the mission. What clashes with nothing stays as it is, unless the room for those that
    do is short.
    """
    ordered = space.ordered(faults)
    if not any(space.clash(one, other) for one, other in combinations(ordered, 2)):
        return ordered
    kept: list[tuple[int, TimedFault]] = []
    for place in sorted(range(len(ordered)), key=lambda place: _length(ordered[place])):
        timed = ordered[place]
        conflicts = space.candidates[timed.fault].conflicts
        taken = {tick for tick, other in kept if other.fault in conflicts}
        free = space.free_windows(timed.fault, ordered[:place] + ordered[place + 1 :])
        tick = _tick_to_keep(timed, free, taken, range(space.duration), rng)
        if tick is not None:
            stays = timed.start <= tick <= timed.finish
            kept.append((tick, timed if stays else timed._replace(start=tick, finish=tick)))
    kept.sort(key=itemgetter(0))
    for i, j in combinations(range(len(kept)), 2):
        (before, one), (after, other) = kept[i], kept[j]
        if space.clash(one, other):
            most = min(after - 1, one.finish, other.finish)
            last = rng.randint(max(before, other.start - 1), most)
            kept[i] = before, one._replace(finish=last)
            kept[j] = after, other._replace(start=last + 1)
    return space.ordered(timed for _, timed in kept)


def _length(timed: TimedFault) -> int:
    return timed.finish - timed.start


def _tick_to_keep(
    timed: TimedFault, free: Sequence[Window], taken: Container[int], ticks: range, rng: Random
) -> int | None:
    """Draw a tick of a window, from its free part if it has one; else the nearest not taken."""
    parts = [(max(first, timed.start), min(last, timed.finish)) for first, last in free]
    own = [part for part in parts if part[0] <= part[1]] or [(timed.start, timed.finish)]
    drawn = rng.randint(*rng.choices(own, [last - first + 1 for first, last in own])[0])
    if drawn not in taken:
        return drawn

    def cost(tick: int) -> tuple[bool, bool, int]:
        is_free = any(first <= tick <= last for first, last in free)
        return not timed.start <= tick <= timed.finish, not is_free, abs(tick - drawn)

    return min((tick for tick in ticks if tick not in taken), key=cost, default=None)


def freely_crossed(
    space: SearchSpace, first: Specification, second: Specification, rng: Random
) -> tuple[Specification, Specification]:
    """Exchange any faults, 1 to half the size of the smaller, and repair what overlaps.

    Neither changes its size: where a mission has no room for the faults that arrive, both stay
    as they are.
    """
    half = min(len(first), len(second)) // 2
    if not half:
        return first, second
    n = rng.randint(1, half)
    mine, theirs = rng.sample(first, len(first)), rng.sample(second, len(second))
    one = repaired(space, [*theirs[:n], *mine[n:]], rng)
    other = repaired(space, [*mine[:n], *theirs[n:]], rng)
    is_whole = len(one) == len(first) and len(other) == len(second)
    return (one, other) if is_whole else (first, second)


def freely_mutated(
    space: SearchSpace, specification: Specification, rng: Random, share: float = 0.5
) -> Specification:
    """Draw any window, values and trigger of timed faults anew, and repair what overlaps."""
    return _freely(space, specification, rng, share, lambda timed: timed.fault)


def transformed(
    space: SearchSpace, specification: Specification, rng: Random, share: float = 0.5
) -> Specification:
    """Put any fault of the pool, at any time, in the place of timed faults, and repair."""
    pool = tuple(space.candidates)
    return _freely(space, specification, rng, share, lambda _: rng.choice(pool))


def _freely(
    space: SearchSpace,
    specification: Specification,
    rng: Random,
    share: float,
    chosen: Callable[[TimedFault], str],
) -> Specification:
    def anew(timed: TimedFault) -> TimedFault:
        fault = chosen(timed)
        window = random_window([(0, space.duration - 1)], rng)
        candidate = space.candidates[fault]
        values = random_values(candidate, candidate.values, rng)
        return TimedFault(fault, *window, values, candidate.drawn_trigger(rng))

    drawn = [anew(timed) if rng.random() < share else timed for timed in specification]
    found = repaired(space, drawn, rng)
    return found if len(found) == len(specification) else specification


CROSSOVERS: Mapping[str, Crossover] = MappingProxyType(
    {"exchange": crossed, "free": freely_crossed}
)
"""Crossovers by their name in a campaign file."""
