"""Stay: every member stays inside an area once it has entered."""

from dataclasses import dataclass
from typing import ClassVar

from mrsfi_runtime.kernel.goal_tasks.common import (
    NEVER,
    NO_MARGIN,
    depth,
    note_presence,
    patience,
    roam_area,
    top_speed,
)
from mrsfi_runtime.kernel.state import State, kernel
from mrsfi_runtime.model.mission import Area, GoalTask


@dataclass(frozen=True, slots=True)
class Stay(GoalTask):
    """Keep every member inside the area from its first entry on."""

    keeps_robots: ClassVar[bool] = True
    area: Area


progress = note_presence
react = roam_area


@kernel
def margin(world: State, g: int, least: float) -> tuple[float, int]:
    """Return how far inside the area the outermost member is, among those that have entered."""
    goal = world.goals[g]
    left = NO_MARGIN
    wait = NEVER
    for m in range(goal.first_member, goal.first_member + goal.n_members):
        member = world.members[m]
        robot = world.robots[member.robot]
        deep = depth(goal, robot)
        if member.reached == 1:
            left = min(left, deep)
        else:
            wait = min(wait, patience(-deep, 0.0, robot.max_speed))
    if left < NO_MARGIN:
        wait = min(wait, patience(left, min(left, least), top_speed(world, goal)))
    return left, wait


@kernel
def violated(view: State, g: int) -> bool:
    """Return whether a member has left the area after it first entered."""
    goal = view.goals[g]
    for m in range(goal.first_member, goal.first_member + goal.n_members):
        member = view.members[m]
        if member.reached == 1 and member.since != view.mission.tick:
            return True
    return False
