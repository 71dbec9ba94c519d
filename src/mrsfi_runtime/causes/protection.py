"""What to protect first: few elements whose faults, kept out, close all weaknesses.

An element is a robot, sensor, message or obstacle; its faults are those of ``elements_of``. A
weakness is *closed* when a fault of its set is kept out. Only weaknesses that break a goal in truth
count. ``cover`` is the greedy algorithm for set cover, ``ladder`` applies it to weaknesses, and
``closing`` has the flights that confirm the result.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

from mrsfi_runtime.causes.mildest import GoalWeakness
from mrsfi_runtime.causes.weakness import MEASURES, FaultSet, Known, form
from mrsfi_runtime.model.faults import FaultPool, Specification, elements_of
from mrsfi_runtime.model.mission import Mission


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
