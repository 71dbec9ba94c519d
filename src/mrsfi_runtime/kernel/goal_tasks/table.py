"""The goal tasks by number, and the functions of each.

States and digests identify a task by its index in ``TASKS``. The functions here choose by that
index: the default check and reaction of each goal, and whether a goal is missed or reached.
"""

import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from mrsfi_runtime.kernel.forecast import ticks_left
from mrsfi_runtime.kernel.goal_tasks import (
    avoid_collision,
    fixed_distance_between_robots,
    gather_samples,
    patrol,
    stay,
    stay_within_mission_area,
    sufficient_energy,
    track,
    visit,
)
from mrsfi_runtime.kernel.goal_tasks.common import NEVER, NO_MARGIN
from mrsfi_runtime.kernel.state import State, kernel
from mrsfi_runtime.model.mission import GoalTask


@dataclass(frozen=True, slots=True)
class OwnTask(GoalTask):
    """A user-defined task, whose check and reaction stand in the regions of its goals.

    The runtime knows only the name of its class in the metamodel.
    """

    class_name: str

    @property
    def name(self) -> str:
        """Name of its class in the metamodel."""
        return self.class_name


TASKS: tuple[type[GoalTask], ...] = (
    avoid_collision.AvoidCollision,
    stay_within_mission_area.StayWithinMissionArea,
    sufficient_energy.SufficientEnergy,
    gather_samples.GatherSamples,
    patrol.Patrol,
    visit.Visit,
    track.Track,
    stay.Stay,
    fixed_distance_between_robots.FixedDistanceBetweenRobots,
)
"""All built-in tasks; the index of a task is its number."""

OWN_TASK = len(TASKS)
"""Number of every user-defined task."""


def number(task: GoalTask) -> int:
    """Return the number of a task, ``GoalState.task``."""
    return TASKS.index(type(task)) if type(task) in TASKS else OWN_TASK


AVOID = TASKS.index(avoid_collision.AvoidCollision)
ENERGY = TASKS.index(sufficient_energy.SufficientEnergy)
SAMPLES = TASKS.index(gather_samples.GatherSamples)
TRACK = TASKS.index(track.Track)
STAY = TASKS.index(stay.Stay)
VISIT = TASKS.index(visit.Visit)

LASTING = tuple(n for n in range(OWN_TASK) if n not in {ENERGY, SAMPLES, VISIT})
"""Tasks that have a margin at every tick; those of the others are of arrivals, or of the end."""


@kernel
def is_missed(world: State, g: int, violated: int) -> bool:
    """Return whether a goal can no longer be met from this tick on.

    Most goals fail with their first violation. Violations of SufficientEnergy and GatherSamples
    are forecasts and do not count. Track and Stay also fail if they are incomplete when the
    mission ends. ``violated`` is the result of the goal's check in the true state, 0 or 1.
    """
    task = world.goals[g].task
    if task == ENERGY:
        return sufficient_energy.is_exhausted(world, g)
    if task == SAMPLES:
        return gather_samples.is_out_of_reach(world, g)
    if violated == 0 and ticks_left(world) == 0:
        if task == TRACK:
            return track.is_unfinished(world, g)
        if task == STAY:
            return stay.is_unfinished(world, g)
    return violated == 1


@kernel
def is_forecast(task: int) -> bool:
    """Return whether violations of a task are forecasts, which have no margin."""
    return task == ENERGY or task == SAMPLES  # noqa: PLR1714 - a compiler takes no set


@kernel
def is_reached(world: State, g: int) -> bool:
    """Return whether a goal has its samples, or all required robots its point or last waypoint."""
    goal = world.goals[g]
    if goal.task == SAMPLES:
        return goal.count >= goal.target
    if goal.task == VISIT:
        return not visit.is_awaited(world, g)
    return goal.task == TRACK and not track.is_unfinished(world, g)


_MODULES = [sys.modules[task.__module__] for task in TASKS]
FUNCTIONS: Mapping[str, tuple[Callable[..., Any] | None, ...]] = {
    role: tuple(getattr(module, name, None) for module in _MODULES)
    for role, name in (("progress", "progress"), ("check", "violated"), ("react", "react"))
}
"""Functions that generated code calls for each role of a goal, by the number of its task."""


def _by_task(
    role: str, functions: Sequence[Callable[..., Any] | None], otherwise: str, inputs: str = ""
) -> Callable[..., Any]:
    """Return a function of state, goal, task number and ``inputs`` that calls the task's function.

    It is a chain of comparisons, because neither compilers nor the common subset support a table
    of functions.
    """
    tasks = {f"task_{n}": each for n, each in enumerate(functions) if each is not None}
    cases = [
        f"    if task == {name[5:]}:\n        return {name}(view, g{inputs})\n" for name in tasks
    ]
    known: dict[str, Any] = {"__name__": __name__, "inf": NO_MARGIN, **tasks}
    exec(f"def {role}(view, g, task{inputs}):\n{''.join(cases)}    return {otherwise}", known)
    found: Callable[..., Any] = known[role]
    return kernel(found)


progress = _by_task("progress", FUNCTIONS["progress"], "None")
"""Record the progress of a goal."""

violated = _by_task("check", FUNCTIONS["check"], "False")
"""Return whether a goal is violated in a state."""

react = _by_task("react", FUNCTIONS["react"], "None")
"""Command the members of a goal."""

margin = _by_task("margin", [module.margin for module in _MODULES], f"inf, {NEVER}", ", least")
"""Return a goal's margin, and after how many ticks it can fall below ``least``."""
