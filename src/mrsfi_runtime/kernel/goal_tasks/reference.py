"""What goals do for which a team wrote nothing: as a task says, by its number."""

import sys
from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Any

from mrsfi_runtime.kernel.compiling import kernel
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
from mrsfi_runtime.kernel.goal_tasks.presence import note_presence
from mrsfi_runtime.kernel.goal_tasks.table import (
    AVOID_COLLISION,
    ENERGY,
    PATROL,
    SAMPLES,
    STAY,
    STAY_WITHIN,
    TASKS,
    TRACK,
    VISIT,
)
from mrsfi_runtime.kernel.guidance import roam_together
from mrsfi_runtime.kernel.state import State

_MODULES = [sys.modules[task.__module__] for task in TASKS]
FUNCTIONS: Mapping[str, tuple[Callable[..., Any] | None, ...]] = MappingProxyType(
    {
        role: tuple(getattr(module, name, None) for module in _MODULES)
        for role, name in (("progress", "progress"), ("check", "violated"), ("react", "react"))
    }
)
"""What generated code calls for each role of a goal, by the number of its task."""


@kernel
def progress(view: State, g: int, task: int) -> None:
    """Note what a goal has to remember."""
    if task == SAMPLES:
        gather_samples.progress(view, g)
    elif task == TRACK:
        track.progress(view, g)
    elif task in (PATROL, VISIT, STAY):
        note_presence(view, g)


@kernel
def violated(view: State, g: int, task: int) -> bool:  # noqa: C901, PLR0911 - a case for each task
    """Return whether a goal is violated in a state."""
    if task == AVOID_COLLISION:
        return avoid_collision.violated(view, g)
    if task == STAY_WITHIN:
        return stay_within_mission_area.violated(view, g)
    if task == ENERGY:
        return sufficient_energy.violated(view, g)
    if task == SAMPLES:
        return gather_samples.violated(view, g)
    if task == PATROL:
        return patrol.violated(view, g)
    if task == VISIT:
        return visit.violated(view, g)
    if task == TRACK:
        return track.violated(view, g)
    if task == STAY:
        return stay.violated(view, g)
    return fixed_distance_between_robots.violated(view, g)


@kernel
def react(ci: State, g: int, task: int) -> None:
    """Command the members of a goal."""
    if task == AVOID_COLLISION:
        avoid_collision.react(ci, g)
    elif task == STAY_WITHIN:
        stay_within_mission_area.react(ci, g)
    elif task == ENERGY:
        sufficient_energy.react(ci, g)
    elif task == SAMPLES:
        gather_samples.react(ci, g)
    elif task in (PATROL, STAY):
        roam_together(ci, ci.goals[g])
    elif task == VISIT:
        visit.react(ci, g)
    elif task == TRACK:
        track.react(ci, g)
    else:
        fixed_distance_between_robots.react(ci, g)
