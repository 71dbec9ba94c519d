"""What search may choose from: faults, windows, values and their landmarks; what excludes what.

References
----------
Source paper, sections III-C b) and III-E a) to c).
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
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
    value_bounds,
)
from mrsfi_runtime.model.mission import Coordinates, Mission

Window: TypeAlias = tuple[int, int]
"""First and last tick, both included."""


_OUTSIDE = 1.2  # mission radii: surely outside, within the default bounds


def landmarks(mission: Mission, fault: Fault) -> tuple[tuple[float, ...], ...]:
    """Return the landmarks of a pool fault within its bounds, each once, its own values first.

    Most values between two bounds are like their neighbours. What stands out are the ends, and,
    among places, where robots begin, goals are pursued and obstacles stand: a believed position
    inside an obstacle is a point that chance hardly ever hits.
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
    center, far = mission.area.center, _OUTSIDE * mission.area.radius
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
    """What search may do with one fault of the pool; ``index`` is its place there.

    ``values`` are the pool's own, shape ``(n_parameters,)``, ``bounds`` the lowest and highest of
    each, ``(n_parameters, 2)``, equal if it is fixed. ``conflicts`` are IDs of the faults that it
    may not overlap, its own included. ``landmarks`` are values within the bounds that mean
    something in the mission, the pool's own first, ``(n_landmarks, n_parameters)``. ``is_place``
    says whether the values are coordinates. ``triggers`` are what it may wait for: nothing first,
    then all triggers of the pool but for those of its own effect.
    """

    index: int
    values: tuple[float, ...]
    bounds: tuple[tuple[float, float], ...]
    is_integer: tuple[bool, ...]
    conflicts: frozenset[str]
    landmarks: tuple[tuple[float, ...], ...] = ()
    is_place: bool = False
    triggers: tuple[str, ...] = ("",)

    def drawn_trigger(self, rng: Random) -> str:
        """Draw what it waits for, each as often; where no trigger is declared, nothing is drawn."""
        return rng.choice(self.triggers) if len(self.triggers) > 1 else ""

    def changed(
        self, values: Sequence[float], change: Callable[[float, float, float, bool], float]
    ) -> tuple[float, ...]:
        """Change the values that evolve; each is given with its bounds and ``is_integer``."""
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
                f"fault pool '{pool.id}' is empty; search needs at least one fault"
            )
        gate = Gate(mission, pool)
        excluded = gate.conflicts()
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
            )
            for index, fault in enumerate(pool)
        }
        return cls(mission.duration, MappingProxyType(candidates), gate)

    def clash(self, first: TimedFault, second: TimedFault) -> bool:
        """Return whether two timed faults may not stand in one specification."""
        return (
            first.start <= second.finish
            and second.start <= first.finish
            and second.fault in self.candidates[first.fault].conflicts
        )

    def require(self, specification: Specification, where: str) -> Specification:
        """Return a specification that ``where`` has made as the record has it, or refuse it."""
        try:
            found = self.gate.admitted(specification)
        except SpecificationError as error:
            raise SpecificationError(f"{where} made: {error}", error.faults) from error
        for timed in found:
            bounds = self.candidates[timed.fault].bounds
            is_within = map(within, timed.values, bounds)
            if timed.finish >= self.duration or not all(is_within):
                raise SpecificationError(
                    f"{where} made {timed}; expected its window within 0 … {self.duration - 1}, "
                    f"and its values within the bounds of the model, {bounds}"
                )
        return self.ordered(found)

    def ordered(self, faults: Iterable[TimedFault]) -> Specification:
        """Return timed faults by start, finish and place in the pool.

        One set of timed faults has one order, hence one record and one outcome. No two of
        a valid specification are equal in all three.
        """
        return tuple(
            sorted(
                faults,
                key=lambda timed: (timed.start, timed.finish, self.candidates[timed.fault].index),
            )
        )

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


def random_window(free: Sequence[Window], rng: Random) -> Window:
    """Draw a window inside one of several free ones.

    Every window comes as often as if a start and a finish were drawn from the whole
    mission, and both drawn again until the window is free.
    """
    n_pairs = [(last - first + 1) ** 2 for first, last in free]
    ((first, last),) = rng.choices(free, weights=n_pairs)
    one, other = rng.randrange(first, last + 1), rng.randrange(first, last + 1)
    return (one, other) if one <= other else (other, one)
