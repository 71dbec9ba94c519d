"""Patrol: every member is inside an area at least once in each period."""

from dataclasses import dataclass
from typing import ClassVar

from mrsfi_runtime.kernel.goal_tasks.common import NEVER, depth, note_presence, patience, roam_area
from mrsfi_runtime.kernel.state import State, kernel
from mrsfi_runtime.model.fault_types import Range
from mrsfi_runtime.model.mission import Area, GoalTask


@dataclass(frozen=True, slots=True)
class Patrol(GoalTask):
    """Have every member inside the area at least once in each period of ticks."""

    keeps_robots: ClassVar[bool] = True
    spares: ClassVar[Range] = Range.TICKS
    area: Area
    period: int


progress = note_presence
react = roam_area


@kernel
def margin(world: State, g: int, least: float) -> tuple[float, int]:
    """Return the ticks to spare of the member that has been outside the area for longest."""
    goal = world.goals[g]
    tick = world.mission.tick
    first = tick
    soonest = NEVER  # tick at which a member can first use up its whole period outside
    for m in range(goal.first_member, goal.first_member + goal.n_members):
        member = world.members[m]
        first = min(first, member.since)
        stays = 0
        if member.since == tick:
            robot = world.robots[member.robot]
            stays = patience(depth(goal, robot), 0.0, robot.max_speed) - 1
        soonest = min(soonest, member.since + stays + goal.period - 1)
    left = float(goal.period - 1 - (tick - first))
    return left, max(soonest - tick - int(min(left, least)), 1)


@kernel
def violated(view: State, g: int) -> bool:
    """Return whether a member has not been inside the area for one period."""
    goal = view.goals[g]
    for m in range(goal.first_member, goal.first_member + goal.n_members):
        if view.mission.tick - view.members[m].since >= goal.period:
            return True
    return False
