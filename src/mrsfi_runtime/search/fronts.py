"""Goal vectors that no other dominates, as a search comes upon them.

References
----------
Source paper, section III-D and equation (3).
"""

from typing import TypeAlias, TypeVar

T = TypeVar("T")

Goals: TypeAlias = tuple[float, ...]
"""Violations of each chosen goal; more is more critical."""


def enter_front(front: dict[Goals, T], goals: Goals, entry: T) -> None:
    """Enter who reached a goal vector, unless another dominates it; of equal ones the newest."""
    others = [known for known in front if known != goals]
    if any(_covers(known, goals) for known in others):
        return
    for known in others:
        if _covers(goals, known):
            del front[known]
    front[goals] = entry


def _covers(goals: Goals, others: Goals) -> bool:
    """Return whether the violations are as many, or more, in every goal."""
    return all(mine >= theirs for mine, theirs in zip(goals, others, strict=True))
