"""The goal tasks, in an order that states and digests know."""

from dataclasses import dataclass

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
