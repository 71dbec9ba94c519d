"""What each fault of a specification is to the violations of a goal."""

from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction

from mrsfi_runtime.causes.cause_set import Places, Question, chosen, without

SOLE = "sole"
"""In the goal's cause set, and enough alone."""

JOINT = "joint"
"""In it, and not enough alone."""

REDUNDANT = "redundant"
"""Outside, and able to take the place of a member."""

MASKING = "masking"
"""Outside, and without it a count of the goal is higher."""

BYSTANDER = "bystander"
"""None of these."""

_RISE = Fraction("1.05")


@dataclass(frozen=True, slots=True)
class GoalCauses:
    """What a goal's violations are due to.

    Attributes
    ----------
    goal
        ID of the goal.
    places
        Its own cause set.
    labels
        One for every fault of the specification.
    """

    goal: str
    places: Places
    labels: tuple[str, ...]


def goal_causes(question: Question, goal: str) -> GoalCauses:
    """Return the cause set of one goal, and what every fault is to it.

    Parameters
    ----------
    question
        Asks for the counts of this goal alone. If it is not violated, that is for nothing: then
        only a fault that hides violations is more than a bystander.
    goal
        ID of the goal.
    """
    everyone = range(len(question.specification))
    places = question.minimum()
    others = [place for place in everyone if place not in places]
    question.flights.fly(
        chosen(question.specification, swapped)
        for other in others
        for swapped in _swaps(places, other)
    )
    labels = {place: SOLE if question.is_kept_by((place,)) else JOINT for place in places}
    for other in others:
        if any(map(question.is_kept_by, _swaps(places, other))):
            labels[other] = REDUNDANT
        else:
            labels[other] = MASKING if _hides(question, other, goal) else BYSTANDER
    return GoalCauses(goal, places, tuple(labels[place] for place in everyone))


def _swaps(places: Places, other: int) -> Iterator[tuple[int, ...]]:
    """Yield a set with another fault in the place of each member."""
    return ((*(place for place in places if place != member), other) for member in places)


def _hides(question: Question, other: int, goal: str) -> bool:
    """Return whether a count of a goal rises where a fault is left out."""
    flights, specification = question.flights, question.specification
    lacking = flights.counts(without(specification, other))
    found = zip(flights.columns, flights.counts(specification), lacking, strict=True)
    return any(left > _RISE * count for column, count, left in found if column.goal == goal)
