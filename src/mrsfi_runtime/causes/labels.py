"""What each fault of a specification is to the violations of a goal."""

from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction

from mrsfi_runtime.causes.cause_set import Places, Question, chosen, without
from mrsfi_runtime.model.faults import Specification

SOLE = "sole"
"""In the goal's cause set, and enough alone."""

JOINT = "joint"
"""In it, and not enough alone."""

REDUNDANT = "redundant"
"""Outside, and able to take the place of a member."""

MASKING = "masking"
"""Outside, and without it a count of the goal is higher."""

LESSER = "lesser"
"""None of these, and yet it breaks the goal alone: others break it more, or hide it."""

BYSTANDER = "bystander"
"""None of these."""

_RISE = Fraction("1.05")


@dataclass(frozen=True, slots=True)
class GoalCauses:
    """What a goal's violations are due to: its cause set, and a label for every fault."""

    goal: str
    places: Places
    labels: tuple[str, ...]


def goal_causes(question: Question, goal: str) -> GoalCauses:
    """Return the cause set of one goal, by its counts alone, and what every fault is to it.

    Where it is not violated, that is for nothing: then only a fault that hides violations, or
    would cause some alone, is more than a bystander.
    """
    whole = question.specification
    everyone = range(len(whole))
    places = question.minimum()
    others = [place for place in everyone if place not in places]
    question.flights.fly(
        chosen(whole, swapped) for other in others for swapped in _swaps(places, other)
    )
    labels = {place: SOLE if question.is_kept_by((place,)) else JOINT for place in places}
    for other in others:
        if any(map(question.is_kept_by, _swaps(places, other))):
            labels[other] = REDUNDANT
        elif _rises(question, goal, whole, without(whole, other), _RISE):
            labels[other] = MASKING
        elif _rises(question, goal, (), (whole[other],), Fraction(1)):
            labels[other] = LESSER
        else:
            labels[other] = BYSTANDER
    return GoalCauses(goal, places, tuple(labels[place] for place in everyone))


def _swaps(places: Places, other: int) -> Iterator[tuple[int, ...]]:
    """Yield a set with another fault in the place of each member."""
    return ((*(place for place in places if place != member), other) for member in places)


def _rises(
    question: Question, goal: str, first: Specification, second: Specification, by: Fraction
) -> bool:
    """Return whether a count of a goal is higher in the second flight, by more than a factor."""
    flights = question.flights
    found = zip(flights.columns, flights.counts(first), flights.counts(second), strict=True)
    return any(after > by * count for column, count, after in found if column.goal == goal)
