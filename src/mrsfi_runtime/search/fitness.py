"""Fitness functions, and the functions that a campaign file names.

``chosen`` returns the function that a setting names: a built-in one, or a user-defined
``module:function``. Python also searches the current folder for user modules. An error in such a
function becomes a ``UsageError`` with file and line. ``Judge`` scores outcomes with the campaign's
fitness function, on the violations that the campaign chose. A higher fitness is more critical.

References
----------
Source paper, section III-E e), equations (1) to (3).
"""

import importlib
import math
import sys
import traceback
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from numbers import Real
from pathlib import Path
from statistics import fmean
from types import MappingProxyType, ModuleType
from typing import Any, NamedTuple, TypeVar, cast

from mrsfi_runtime.errors import EvaluationError, UsageError, expected
from mrsfi_runtime.fence import fenced, words
from mrsfi_runtime.model.faults import Specification
from mrsfi_runtime.model.mission import Mission, Outcome
from mrsfi_runtime.record.settings import CampaignSettings

T = TypeVar("T")


def chosen(settings: CampaignSettings, key: str, table: Mapping[str, T]) -> T:
    """Return the entry of a table that a setting names, or the function of a user's module."""
    name = getattr(settings, key)
    where = settings.where(key)
    if ":" in name:
        return cast("T", user_function(name, where))
    if name not in table:
        known = expected(name, table, "'module:function' or one of")
        raise UsageError(f"{where}: found '{name}'; {known}")
    return table[name]


def user_function(name: str, where: str) -> Callable[..., Any]:
    """Return the function that ``module:function`` names; ``where`` is the file and key."""
    module_name, _, attribute = name.partition(":")
    if not all(part.isidentifier() for part in (*module_name.split("."), attribute)):
        raise UsageError(
            f"{where}: found '{name}'; expected 'module:function', such as 'my_search:creep'"
        )
    module = imported(module_name, f"{where}: found '{name}'")
    function: Callable[..., Any] | None = getattr(module, attribute, None)
    if not callable(function):
        functions = [
            key
            for key, value in vars(module).items()
            if callable(value) and getattr(value, "__module__", None) == module.__name__
        ]
        known = ", ".join(functions) or "none"
        raise UsageError(
            f"{where}: found '{name}'; expected a function of {module.__file__}, which has: {known}"
        )
    return errors_by_line(f"{where}: '{name}'")(function)


@contextmanager
def errors_by_line(where: str) -> Iterator[None]:
    """Turn each error of a body or function into a ``UsageError`` with file and line."""

    def located(error: BaseException) -> UsageError:
        cause = f"{type(error).__name__}: {words(error)}"
        return UsageError(f"{where} raised an error at {_place(error)}: {cause}; correct it there")

    with fenced(located):
        yield


def imported(name: str, where: str) -> ModuleType:
    """Return a user's module, found in the current folder or on Python's path."""
    folder = str(Path.cwd())
    sys.path.insert(0, folder)
    try:
        with errors_by_line(f"{where}; its module"):
            return importlib.import_module(name)
    except UsageError as error:
        missing = error.__cause__
        if isinstance(missing, ModuleNotFoundError) and missing.name == name.partition(".")[0]:
            raise UsageError(
                f"{where}; expected a module '{name}' in the current folder, {folder}, or on "
                "Python's path; set PYTHONPATH to its folder"
            ) from error
        raise
    finally:
        sys.path.remove(folder)


def _place(error: BaseException) -> str:
    if isinstance(error, SyntaxError) and error.filename:
        return f"{error.filename}:{error.lineno}"
    frames = traceback.extract_tb(error.__traceback__)
    ours, pythons = (str(Path(str(file)).parents[1]) for file in (__file__, importlib.__file__))
    others = (ours, pythons, sys.prefix, "<")  # not the user's code
    frame = ([each for each in frames if not each.filename.startswith(others)] or frames)[-1]
    return f"{frame.filename}:{frame.lineno}"


@dataclass(frozen=True, slots=True)
class FitnessInput:
    """The input of a fitness function: the result of one evaluation.

    ``violations`` is the count that the campaign chose, of every goal in model order; ``goals`` are
    the indexes of the chosen goals, by default of all. ``duration`` is in ticks.
    """

    outcome: Outcome
    violations: tuple[int, ...]
    goals: tuple[int, ...]
    duration: int


class Score(NamedTuple):
    """The score of a specification, which an algorithm receives; higher is more critical.

    ``fitness`` is finite, ``goals`` the violations of each chosen goal, shape ``(n_chosen,)``.
    ``outcome`` is that of the first mission seed; ``None`` if the flight ended with an error.
    """

    fitness: float
    goals: tuple[float, ...]
    outcome: Outcome | None = None


_GREATEST = 1e100
"""The greatest fitness: its square and the sum over a population are floats, too."""

_TOTAL = 0.3
_DISTINCT = 0.7


def weighted(findings: FitnessInput) -> float:
    """Return the weighted sum of all violations and of the number of violated goals.

    References
    ----------
    Source paper, equation (1), to the letter: the second term is at most ``0.7 n_goals``.
    """
    n_distinct = sum(map(bool, findings.violations))
    return _TOTAL * sum(findings.violations) + _DISTINCT * n_distinct


def weighted_normalised(findings: FitnessInput) -> float:
    """Return equation (1) with both terms as shares of what is possible, 0 … 1.

    Notes
    -----
    Deviates from the paper, where the total outweighs the number of goals some 400 times.
    """
    n_goals = len(findings.violations)
    total = sum(findings.violations) / (n_goals * findings.duration)
    return _TOTAL * total + _DISTINCT * sum(map(bool, findings.violations)) / n_goals


def focused(findings: FitnessInput) -> float:
    """Return the violations of the chosen goals.

    References
    ----------
    Source paper, equation (2).
    """
    return float(sum(findings.violations[goal] for goal in findings.goals))


def nearest(findings: FitnessInput) -> float:
    """Return the violations of the chosen goals, plus how close the others came to a violation.

    A goal without violations contributes 1 / (1 + true margin), or 0 without a margin; the mean
    over the goals is added. It is less than one violation, and guides a search where all are 0.

    Notes
    -----
    It is meant for one goal, because units of margins differ.
    """
    margins = findings.outcome.margins or ()
    near = 0.0
    for goal in findings.goals:
        margin = margins[goal] if margins and not findings.violations[goal] else None
        near += 0.0 if margin is None else 1.0 / (1.0 + max(margin[0], 0.0))
    return focused(findings) + near / max(len(findings.goals), 1)


FITNESS_FUNCTIONS: Mapping[str, Callable[[FitnessInput], float]] = MappingProxyType(
    {each.__name__: each for each in (weighted, weighted_normalised, focused, nearest)}
)
"""Fitness functions by their name in a campaign file: each returns a number >= 0."""


class Judge:
    """Scores outcomes by the settings of a campaign."""

    def __init__(self, settings: CampaignSettings, mission: Mission) -> None:
        goals = settings.goals or mission.goal_ids
        self.n_goals = len(goals)
        self._goals = tuple(mission.goal_ids.index(goal) for goal in goals)
        self._duration = mission.duration
        self._measure = settings.violations
        self._fitness = chosen(settings, "fitness", FITNESS_FUNCTIONS)

    def score(self, outcome: Outcome, specification: Specification = ()) -> Score:
        """Return the fitness and the goal vector of one outcome, under a specification."""
        violations = getattr(outcome, self._measure)
        fitness = self._fitness(FitnessInput(outcome, violations, self._goals, self._duration))
        if not isinstance(fitness, Real):
            found = type(fitness).__name__
            raise EvaluationError(f"the fitness function returned {found}; expected a number")
        try:
            value = float(fitness)
        except OverflowError:
            value = math.inf if fitness > 0 else -math.inf
        if not abs(value) <= _GREATEST:  # DEAP takes NaN for best
            raise EvaluationError(
                f"the fitness of {specification} is {value:g} as a float; expected a finite "
                f"number from {-_GREATEST:g} to {_GREATEST:g}"
            )
        return Score(value, self.goals(outcome))

    def goals(self, outcome: Outcome) -> tuple[int, ...]:
        """Return the goal vector of one outcome, shape ``(n_chosen,)``: equation (3)."""
        violations = getattr(outcome, self._measure)
        return tuple(violations[goal] for goal in self._goals)


def averaged(scores: Sequence[Score]) -> Score:
    """Return the mean of the scores that one specification has under several mission seeds."""
    vectors = zip(*(score.goals for score in scores), strict=True)
    return Score(fmean(score.fitness for score in scores), tuple(fmean(goal) for goal in vectors))
