"""Mutation and crossover of fault specifications under the no-overlap restriction.

Both are functions of their arguments and the random generator: a specification goes in,
another comes out, and what went in stays as it was.

References
----------
Source paper, sections III-E b) and c), VI a).
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from random import Random
from types import MappingProxyType
from typing import TypeAlias

from mrsfi_runtime.model.faults import Specification, TimedFault
from mrsfi_runtime.search.space import Candidate, SearchSpace, random_window

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


CROSSOVERS: Mapping[str, Crossover] = MappingProxyType({"exchange": crossed})
"""Crossovers by their name in a campaign file."""
