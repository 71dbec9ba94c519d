"""How critical an outcome is: the paper's fitness functions, on believed violations.

References
----------
Source paper, section III-E e), equations (1) to (3).
"""

from collections.abc import Callable, Mapping, Sequence
from types import MappingProxyType
from typing import TypeAlias

from mrsfi_runtime.model.outcome import Outcome

FitnessFunction: TypeAlias = Callable[[Outcome, Sequence[int], int], float]
"""From an outcome, the indexes of the chosen goals and the mission's duration; >= 0."""

_TOTAL = 0.3
_DISTINCT = 0.7


def weighted(outcome: Outcome, goals: Sequence[int], duration: int) -> float:  # noqa: ARG001 - FitnessFunction
    """Return violations of all goals, and the number of goals violated, weighted.

    References
    ----------
    Source paper, equation (1), to the letter: the second term is at most ``0.7 n_goals``.
    """
    return _TOTAL * sum(outcome.believed) + _DISTINCT * _n_distinct(outcome)


def weighted_normalised(outcome: Outcome, goals: Sequence[int], duration: int) -> float:  # noqa: ARG001 - FitnessFunction
    """Return equation (1) with both terms as shares of what is possible, 0 … 1.

    Notes
    -----
    Deviates from the paper, where the total outweighs the number of goals some 400 times.
    """
    n_goals = len(outcome.believed)
    total = sum(outcome.believed) / (n_goals * duration)
    return _TOTAL * total + _DISTINCT * _n_distinct(outcome) / n_goals


def focused(outcome: Outcome, goals: Sequence[int], duration: int) -> float:  # noqa: ARG001 - FitnessFunction
    """Return the violations of the chosen goals.

    References
    ----------
    Source paper, equation (2).
    """
    return float(sum(goal_vector(outcome, goals)))


def goal_vector(outcome: Outcome, goals: Sequence[int]) -> tuple[int, ...]:
    """Return the violations of each chosen goal, shape ``(n_chosen,)``.

    References
    ----------
    Source paper, equation (3).
    """
    return tuple(outcome.believed[goal] for goal in goals)


def _n_distinct(outcome: Outcome) -> int:
    return sum(1 for violations in outcome.believed if violations)


FITNESS_FUNCTIONS: Mapping[str, FitnessFunction] = MappingProxyType(
    {"weighted": weighted, "weighted_normalised": weighted_normalised, "focused": focused}
)
"""Fitness functions by their name in a campaign file."""
