"""Patrol: every member is inside an area at least once in each period."""

from dataclasses import dataclass
from typing import ClassVar

from mrsfi_runtime.kernel.compiling import kernel
from mrsfi_runtime.kernel.goal_tasks.presence import note_presence, roam_area
from mrsfi_runtime.kernel.state import State
from mrsfi_runtime.model.mission import Area, GoalTask


@dataclass(frozen=True, slots=True)
class Patrol(GoalTask):
    """Have every member inside the area at least once in each period of ticks."""

    keeps_robots: ClassVar[bool] = True
    area: Area
    period: int


progress = note_presence
react = roam_area


@kernel
def violated(view: State, g: int) -> bool:
    """Return whether a member has not been inside the area for one period."""
    goal = view.goals[g]
    for m in range(goal.first_member, goal.first_member + goal.n_members):
        if view.mission.tick - view.members[m].since >= goal.period:
            return True
    return False
