"""Stay: every member stays inside an area once it has entered."""

from dataclasses import dataclass
from typing import ClassVar

from mrsfi_runtime.kernel.compiling import kernel
from mrsfi_runtime.kernel.goal_tasks.presence import note_presence
from mrsfi_runtime.kernel.guidance import roam_together
from mrsfi_runtime.kernel.state import State
from mrsfi_runtime.model.mission import Area, GoalTask


@dataclass(frozen=True, slots=True)
class Stay(GoalTask):
    """Keep every member inside the area from its first entry on."""

    keeps_robots: ClassVar[bool] = True
    area: Area


progress = note_presence


@kernel
def violated(view: State, g: int) -> bool:
    """Return whether a member has left the area after it first entered."""
    goal = view.goals[g]
    for m in range(goal.first_member, goal.first_member + goal.n_members):
        member = view.members[m]
        if member.reached == 1 and member.since != view.mission.tick:
            return True
    return False


@kernel
def is_unentered(world: State, g: int) -> bool:
    """Return whether a member has not been in the area yet."""
    goal = world.goals[g]
    for m in range(goal.first_member, goal.first_member + goal.n_members):
        if world.members[m].reached == 0:
            return True
    return False


@kernel
def react(ci: State, g: int) -> None:
    """Head for the area from outside, roam inside it."""
    roam_together(ci, ci.goals[g])
