"""The goal tasks by number, and which functions each has.

States and digests know a task by its place in ``TASKS``. Functions here choose by that number: what
goals do for which a team wrote nothing, and whether the purpose of a goal is certainly not met.
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
from mrsfi_runtime.kernel.goal_tasks.common import NEVER, NO_MARGIN, is_awaited
from mrsfi_runtime.kernel.state import State, kernel
from mrsfi_runtime.model.mission import GoalTask


@dataclass(frozen=True, slots=True)
class OwnTask(GoalTask):
    """A task of a team's own: what it asks for stands in the regions of its goals.

    The runtime knows the name of its class in the metamodel, and no more.
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
"""All tasks that stand here; where one stands is its number."""

OWN_TASK = len(TASKS)
"""Number of every task of a team's own."""


def number(task: GoalTask) -> int:
    """Return the number of a task, ``GoalState.task``."""
    return TASKS.index(type(task)) if type(task) in TASKS else OWN_TASK


ENERGY = TASKS.index(sufficient_energy.SufficientEnergy)
SAMPLES = TASKS.index(gather_samples.GatherSamples)
TRACK = TASKS.index(track.Track)
STAY = TASKS.index(stay.Stay)
VISIT = TASKS.index(visit.Visit)


@kernel
def is_missed(world: State, g: int, violated: int) -> bool:
    """Return whether it is certain from this tick on that a goal's purpose is not met.

    For most tasks that is the first violation, which no later tick makes up for. Violations of
    SufficientEnergy and GatherSamples are forecasts, and do not count; Track and Stay may also
    have come to nothing when the mission ends. ``violated`` is what the goal's check says of the
    true state, 0 or 1.
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
            return is_awaited(world, g)
    return violated == 1


@kernel
def is_reached(world: State, g: int) -> bool:
    """Return whether a goal has its samples, or its robots were at its point, or at the last."""
    goal = world.goals[g]
    if goal.task == SAMPLES:
        return goal.count >= goal.target
    if goal.task == VISIT:
        return not is_awaited(world, g)
    return goal.task == TRACK and not track.is_unfinished(world, g)


_MODULES = [sys.modules[task.__module__] for task in TASKS]
FUNCTIONS: Mapping[str, tuple[Callable[..., Any] | None, ...]] = {
    role: tuple(getattr(module, name, None) for module in _MODULES)
    for role, name in (("progress", "progress"), ("check", "violated"), ("react", "react"))
}
"""What generated code calls for each role of a goal, by the number of its task."""


def _by_task(
    role: str, functions: Sequence[Callable[..., Any] | None], otherwise: str, inputs: str = ""
) -> Callable[..., Any]:
    """Return a function of state, goal and number of a task, and more: that of the task.

    It is a chain of comparisons, as written by hand: neither compilers nor the common subset know
    a table of functions.
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
"""Note what a goal has to remember."""

violated = _by_task("check", FUNCTIONS["check"], "False")
"""Return whether a goal is violated in a state."""

react = _by_task("react", FUNCTIONS["react"], "None")
"""Command the members of a goal."""

margin = _by_task("margin", [module.margin for module in _MODULES], f"inf, {NEVER}", ", least")
"""Return how far a goal is from being violated, and after how many ticks it can be nearer."""
