"""The search space, and the operators that draw and vary fault specifications.

``SearchSpace`` holds the faults of a pool, their bounds and landmarks, and their conflicts.
Operators are functions of their arguments and the random generator; they return new
specifications. In each of these, conflicting faults never overlap. The paper's operators ensure
that at every step; the free ones draw without regard to conflicts, and repair the result.

Read ``SearchSpace`` first, then mutation, crossover, repair, and the random specifications.

References
----------
Source paper, sections III-C b) and III-E a) to c), VI a); of the free ones, section VII.
"""

import math
from collections.abc import Callable, Container, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from operator import itemgetter
from random import Random
from types import MappingProxyType
from typing import Self, TypeAlias

from mrsfi_runtime.errors import SpecificationError
from mrsfi_runtime.kernel.goal_tasks.visit import Visit
from mrsfi_runtime.model.faults import (
    Fault,
    FaultPool,
    Gate,
    Specification,
    TimedFault,
    elements_of,
    value_bounds,
)
from mrsfi_runtime.model.mission import Coordinates, Mission
from mrsfi_runtime.record.settings import CampaignSettings

Window: TypeAlias = tuple[int, int]
"""First and last tick, both included."""


def landmarks(mission: Mission, fault: Fault) -> tuple[tuple[float, ...], ...]:
    """Return the landmarks of a pool fault within its bounds, each once, its own values first.

    Landmarks are the ends of bounds. For coordinates, they are the places of robots, goals and
    obstacles: random coordinates are hardly ever inside an obstacle.
    """
    bounds = value_bounds(mission, fault)
    if fault.kind.is_place:
        found = [(float(at.x), float(at.y), *fault.values[2:]) for at in _points(mission)]
    else:
        found = [
            (*fault.values[:place], end, *fault.values[place + 1 :])
            for place, ends in enumerate(bounds)
            for end in ends
        ]
    known = dict.fromkeys((fault.values, *found))
    return tuple(values for values in known if all(map(within, values, bounds)))


def within(value: float, bounds: tuple[float, float]) -> bool:
    """Return whether a value lies within its bounds."""
    return bounds[0] <= value <= bounds[1]


def _points(mission: Mission) -> Iterator[Coordinates]:
    center = mission.area.center
    far = 1.2 * mission.area.radius  # outside the area, within the default bounds
    yield from (robot.position for robot in mission.robots)
    yield from (obstacle.area.center for obstacle in mission.obstacles)
    for goal in mission.goals:
        if goal.area is not None:
            yield goal.area.center
        if isinstance(goal.task, Visit):
            yield goal.task.coordinates
    yield center
    for x, y in ((far, 0.0), (-far, 0.0), (0.0, far), (0.0, -far)):
        yield Coordinates(center.x + x, center.y + y)


@dataclass(frozen=True, slots=True)
class Candidate:
    """A fault of the pool, and how a search may vary it; ``index`` is its place in the pool.

    ``values`` are those of the pool, shape ``(n_parameters,)``, ``bounds`` the lowest and highest
    of each, ``(n_parameters, 2)``, equal if it is fixed. ``conflicts`` are IDs of the faults that
    it may not overlap, itself included. ``landmarks`` has shape ``(n_landmarks, n_parameters)``.
    ``is_place`` is whether the values are coordinates. ``triggers`` are the IDs of triggers that it
    may have: none first, as ``""``, then the pool's triggers, except those of its own effect.
    """

    index: int
    values: tuple[float, ...]
    bounds: tuple[tuple[float, float], ...]
    is_integer: tuple[bool, ...]
    conflicts: frozenset[str]
    landmarks: tuple[tuple[float, ...], ...] = ()
    is_place: bool = False
    triggers: tuple[str, ...] = ("",)
    kin: tuple[str, ...] = ()

    def changed(
        self, values: Sequence[float], change: Callable[[float, float, float, bool], float]
    ) -> tuple[float, ...]:
        """Change the values that are not fixed; each comes with its bounds and ``is_integer``."""
        return tuple(
            change(value, low, high, is_integer) if low < high else value
            for value, (low, high), is_integer in zip(
                values, self.bounds, self.is_integer, strict=True
            )
        )


@dataclass(frozen=True, slots=True)
class SearchSpace:
    """All fault specifications of one mission and pool; ``candidates`` in pool order."""

    duration: int
    candidates: Mapping[str, Candidate]
    gate: Gate

    @classmethod
    def of(cls, mission: Mission, pool: FaultPool) -> Self:
        """Return the space of a mission and its fault pool, which may not be empty."""
        if not len(pool):
            raise SpecificationError(
                f"fault pool '{pool.id}' is empty; a search needs at least one fault"
            )
        gate = Gate(mission, pool)
        excluded, kin = gate.conflicts(), _kin(mission, pool)
        candidates = {
            fault.id: Candidate(
                index=index,
                values=fault.values,
                bounds=value_bounds(mission, fault),
                is_integer=tuple(parameter.is_integer for parameter in fault.kind.parameters),
                conflicts=excluded[fault.id],
                landmarks=landmarks(mission, fault),
                is_place=fault.kind.is_place,
                triggers=("", *(each.id for each in pool.triggers if each.of != (fault.id,))),
                kin=kin[fault.id],
            )
            for index, fault in enumerate(pool)
        }
        return cls(mission.duration, MappingProxyType(candidates), gate)

    def clash(self, first: TimedFault, second: TimedFault) -> bool:
        """Return whether two timed faults may not be in one specification."""
        return (
            first.start <= second.finish
            and second.start <= first.finish
            and second.fault in self.candidates[first.fault].conflicts
        )

    def require(self, specification: Specification, where: str) -> Specification:
        """Return a user-defined operator's specification in recorded order, or refuse it."""
        try:
            admitted = self.gate.admitted(specification)
        except SpecificationError as error:
            raise SpecificationError(f"{where} returned: {error}", error.faults) from error
        for timed in admitted:
            bounds = self.candidates[timed.fault].bounds
            is_within = map(within, timed.values, bounds)
            if timed.finish >= self.duration or not all(is_within):
                raise SpecificationError(
                    f"{where} returned {timed}; expected its window within ticks 0 … "
                    f"{self.duration - 1}, and its values within the model's bounds, {bounds}"
                )
        return self.ordered(admitted)

    def ordered(self, faults: Iterable[TimedFault]) -> Specification:
        """Return timed faults by start, finish and place in the pool.

        So each set of timed faults has one order, one record and one outcome.
        """
        ordered = sorted(faults, key=lambda f: (f.start, f.finish, self.candidates[f.fault].index))
        return tuple(ordered)

    def timed(
        self, fault: str, window: Window, values: tuple[float, ...], rng: Random
    ) -> TimedFault:
        """Return a timed fault; its trigger is drawn, or none, all of them equally likely."""
        triggers = self.candidates[fault].triggers
        drawn = rng.choice(triggers) if len(triggers) > 1 else ""  # without any, no number is drawn
        return TimedFault(fault, *window, values, drawn)

    def free_windows(self, fault: str, others: Iterable[TimedFault]) -> list[Window]:
        """Return the longest windows in which a fault conflicts with no other, in order."""
        excluded = self.candidates[fault].conflicts
        taken = sorted((other.start, other.finish) for other in others if other.fault in excluded)
        free = []
        tick = 0
        for start, finish in taken:
            if start > tick:
                free.append((tick, start - 1))
            tick = max(tick, finish + 1)
        if tick < self.duration:
            free.append((tick, self.duration - 1))
        return free


def _kin(mission: Mission, pool: FaultPool) -> Mapping[str, tuple[str, ...]]:
    """Return for every fault the others that touch one of its robots or elements."""
    struck = {fault.id: elements_of(mission, fault) for fault in pool}
    return {
        one: tuple(other for other in struck if other != one and struck[one] & struck[other])
        for one in struck
    }


def widest(free: Sequence[Window]) -> Window:
    """Return the longest window, of equal ones the first."""
    return max(free, key=lambda window: window[1] - window[0])


def random_window(free: Sequence[Window], rng: Random) -> Window:
    """Draw a window inside free ones, as if drawn from the whole mission until one is free."""
    n_pairs = [(last - first + 1) ** 2 for first, last in free]
    ((first, last),) = rng.choices(free, weights=n_pairs)
    one, other = rng.randrange(first, last + 1), rng.randrange(first, last + 1)
    return (one, other) if one <= other else (other, one)


Mutation: TypeAlias = Callable[[SearchSpace, Specification, Random, float], Specification]
"""Returns a mutated specification; the number is the chance of each fault to change."""

Crossover: TypeAlias = Callable[
    [SearchSpace, Specification, Specification, Random], tuple[Specification, Specification]
]
"""Returns two offspring of two specifications."""

Block: TypeAlias = tuple[tuple[int, ...], tuple[int, ...]]
"""Places, in two specifications, of faults that can only be exchanged together."""


def mutated(
    space: SearchSpace, specification: Specification, rng: Random, share: float = 0.5
) -> Specification:
    """Redraw window, values and trigger of each timed fault with probability ``share``.

    The paper states no probability. Windows lie where no other fault conflicts, values in bounds.
    """
    faults = list(specification)
    for place, timed in enumerate(faults):
        if rng.random() < share:
            free = space.free_windows(timed.fault, faults[:place] + faults[place + 1 :])
            window = random_window(free, rng)
            values = random_values(space.candidates[timed.fault], timed.values, rng)
            faults[place] = space.timed(timed.fault, window, values, rng)
    return space.ordered(faults)


def random_values(
    candidate: Candidate, values: tuple[float, ...], rng: Random
) -> tuple[float, ...]:
    """Draw new values within their bounds; keep those that are fixed."""

    def drawn(_: float, low: float, high: float, is_integer: bool) -> float:
        if is_integer:
            return float(rng.randint(int(low), int(high)))
        return min(high, max(low, rng.uniform(low, high)))  # rounding may leave the bounds

    return candidate.changed(values, drawn)


def crossed(
    space: SearchSpace, first: Specification, second: Specification, rng: Random
) -> tuple[Specification, Specification]:
    """Exchange faults between two specifications.

    The number to exchange is drawn from 1 to half the size of the smaller one. Of the allowed
    exchanges, the one nearest to this number is made. Faults of the two specifications that clash
    form blocks, which are exchanged as a whole, so an allowed exchange is a set of blocks.

    In the paper, individuals can grow. Here neither grows beyond the larger of the two: more
    faults mean more violations, so the search would evolve sizes in place of faults.
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
    """Return the smallest groups of faults of two specifications that can be exchanged.

    A fault that both have is left out, because exchanging it changes nothing.
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
    """Yield the connected components of a graph, all in ascending order."""
    visited: set[int] = set()
    for root in range(len(neighbours)):
        if root in visited:
            continue
        visited.add(root)
        group = [root]
        for member in group:
            for other in neighbours[member]:
                if other not in visited:
                    visited.add(other)
                    group.append(other)
        yield sorted(group)


def _combined(
    blocks: Sequence[Block], limit: int, wanted: int
) -> dict[tuple[int, int], tuple[int, ...]]:
    """Return one choice of blocks for each pair of sizes that blocks can add up to.

    A pair counts the faults that leave each specification, at most ``limit`` and not both 0. All
    possible pairs are included, unless the search ended early at ``wanted`` of both.
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
    """Cut the windows of conflicting faults until none overlap.

    Each fault keeps one tick of its window, drawn for the shortest windows first. Two overlapping
    windows that conflict are cut between their ticks. A fault whose ticks are all taken moves to
    the nearest free tick, and is removed only if there is none. Faults without a clash stay as
    they are, unless others need their room.
    """
    ordered = space.ordered(faults)
    if not any(space.clash(one, other) for one, other in combinations(ordered, 2)):
        return ordered
    kept: list[tuple[int, TimedFault]] = []
    lengths = [timed.finish - timed.start for timed in ordered]
    for place in sorted(range(len(ordered)), key=lengths.__getitem__):
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
    """Exchange any faults, 1 to half the size of the smaller, and repair overlaps.

    Both stay as they are if the mission has no room for the new faults.
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
    space: SearchSpace,
    specification: Specification,
    rng: Random,
    share: float = 0.5,
    pool: Sequence[str] = (),
) -> Specification:
    """Redraw window, values and trigger of timed faults at random, and repair overlaps.

    With a ``pool``, they become random faults of it.
    """

    def anew(timed: TimedFault) -> TimedFault:
        fault = rng.choice(pool) if pool else timed.fault
        window = random_window([(0, space.duration - 1)], rng)
        candidate = space.candidates[fault]
        return space.timed(fault, window, random_values(candidate, candidate.values, rng), rng)

    drawn = [anew(timed) if rng.random() < share else timed for timed in specification]
    found = repaired(space, drawn, rng)
    return found if len(found) == len(specification) else specification


def transformed(
    space: SearchSpace, specification: Specification, rng: Random, share: float = 0.5
) -> Specification:
    """Replace timed faults by random faults of the pool, at random times, and repair overlaps."""
    return freely_mutated(space, specification, rng, share, tuple(space.candidates))


CROSSOVERS: Mapping[str, Crossover] = MappingProxyType(
    {"exchange": crossed, "free": freely_crossed}
)
"""Crossovers by their name in a campaign file."""


def first_size(settings: CampaignSettings, rng: Random) -> int:
    """Return the size of an individual of the first population, drawn if the campaign minimises."""
    return rng.randint(1, settings.faults) if settings.minimise else settings.faults


def random_specification(space: SearchSpace, n_faults: int, rng: Random) -> Specification:
    """Draw timed faults from the pool, no two conflicting ones overlapping.

    Each fault is drawn with replacement, its window among those that earlier ones leave free, and
    its trigger; its values are the pool's. When no fault has a free tick left, an earlier window is
    cut short, as the paper's lists always hold 20 faults. Only too short a mission gets fewer.
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
            values = space.candidates[fault].values
            placed.append(space.timed(fault, random_window(free, rng), values, rng))
        else:
            candidates.remove(fault)
    return space.ordered(placed)


def varied_fault(space: SearchSpace, fault: str, free: Sequence[Window], rng: Random) -> TimedFault:
    """Draw a variant of a fault: values of one of three kinds, in the widest or a random window.

    Its trigger is drawn last, if the pool has triggers.
    """
    candidate = space.candidates[fault]
    values, kind = candidate.values, rng.choice(("own", "landmark", "random"))
    if kind == "landmark":
        values = rng.choice(candidate.landmarks)
    elif kind == "random":
        values = random_values(candidate, values, rng)
    window = widest(free) if rng.random() < 0.5 else random_window(free, rng)
    return space.timed(fault, window, values, rng)


Draw: TypeAlias = tuple[str, bool, str]
"""How ``varied_fault`` draws: the kind of values, whether the window is whole, the trigger."""


def drawn_as(space: SearchSpace, timed: TimedFault) -> Draw:
    """Return how a variant is drawn if its fault flies alone."""
    candidate, values = space.candidates[timed.fault], timed.values
    kind = "landmark" if values in candidate.landmarks else "random"
    is_whole = (timed.start, timed.finish) == (0, space.duration - 1)
    return "own" if values == candidate.values else kind, is_whole, timed.trigger


def draws(space: SearchSpace, fault: str) -> dict[Draw, tuple[float, float]]:
    """Return each way to draw a fault alone: its probability, and how many variants it has."""
    candidate = space.candidates[fault]
    n_marks = len(candidate.landmarks)
    n_others = n_marks - (candidate.values in candidate.landmarks)
    is_fixed = all(low == high for low, high in candidate.bounds)
    chances = {
        "own": (1 + (n_marks - n_others) / n_marks + is_fixed, 1),
        "landmark": (n_others / n_marks, n_others),
        "random": (1 - is_fixed, math.inf),
    }
    n_triggers = len(candidate.triggers)
    return {
        (kind, is_whole, trigger): (
            chance / (6 * n_triggers),
            n_variants if is_whole else math.inf,
        )
        for kind, (chance, n_variants) in chances.items()
        for is_whole in (True, False)
        for trigger in candidate.triggers
        if chance
    }


def varied_specification(
    space: SearchSpace, n_faults: int, rng: Random, is_allowed: Callable[[frozenset[str]], bool]
) -> Specification:
    """Draw variants of up to ``n_faults`` different faults, as far as sets of them are allowed."""
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
    if long:
        timed = placed[place := rng.choice(long)]
        placed[place] = timed._replace(finish=rng.randint(timed.start, timed.finish - 1))
    return bool(long)
