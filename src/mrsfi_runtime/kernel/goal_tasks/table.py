"""The goal tasks, in an order that states and digests know."""

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
from mrsfi_runtime.model.mission import GoalTask

__all__ = [
    "OWN_TASK",
    "TASKS",
    "avoid_collision",
    "fixed_distance_between_robots",
    "gather_samples",
    "number",
    "patrol",
    "stay",
    "stay_within_mission_area",
    "sufficient_energy",
    "track",
    "visit",
]

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
