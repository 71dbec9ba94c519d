"""What goals do for which a team wrote nothing: as a task says, by its number."""

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
from mrsfi_runtime.kernel.goal_tasks.table import TASKS
from mrsfi_runtime.kernel.guidance import roam_together
from mrsfi_runtime.kernel.state import State

AVOID_COLLISION = TASKS.index(avoid_collision.AvoidCollision)
STAY_WITHIN_MISSION_AREA = TASKS.index(stay_within_mission_area.StayWithinMissionArea)
SUFFICIENT_ENERGY = TASKS.index(sufficient_energy.SufficientEnergy)
GATHER_SAMPLES = TASKS.index(gather_samples.GatherSamples)
PATROL = TASKS.index(patrol.Patrol)
VISIT = TASKS.index(visit.Visit)
TRACK = TASKS.index(track.Track)
STAY = TASKS.index(stay.Stay)

_MODULES: tuple[Any, ...] = (
    avoid_collision,
    stay_within_mission_area,
    sufficient_energy,
    gather_samples,
    patrol,
    visit,
    track,
    stay,
    fixed_distance_between_robots,
)

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
    if task == GATHER_SAMPLES:
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
    if task == STAY_WITHIN_MISSION_AREA:
        return stay_within_mission_area.violated(view, g)
    if task == SUFFICIENT_ENERGY:
        return sufficient_energy.violated(view, g)
    if task == GATHER_SAMPLES:
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
    elif task == STAY_WITHIN_MISSION_AREA:
        stay_within_mission_area.react(ci, g)
    elif task == SUFFICIENT_ENERGY:
        sufficient_energy.react(ci, g)
    elif task == GATHER_SAMPLES:
        gather_samples.react(ci, g)
    elif task in (PATROL, STAY):
        roam_together(ci, ci.goals[g])
    elif task == VISIT:
        visit.react(ci, g)
    elif task == TRACK:
        track.react(ci, g)
    else:
        fixed_distance_between_robots.react(ci, g)
