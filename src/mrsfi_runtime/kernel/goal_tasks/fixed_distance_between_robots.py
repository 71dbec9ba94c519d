"""FixedDistanceBetweenRobots: every pair of members keeps a distance."""

import math
from dataclasses import dataclass

from mrsfi_runtime.kernel.commands import steer
from mrsfi_runtime.kernel.geometry import distance
from mrsfi_runtime.kernel.goal_tasks.common import patience
from mrsfi_runtime.kernel.state import State, excess, kernel
from mrsfi_runtime.model.mission import GoalTask


@dataclass(frozen=True, slots=True)
class FixedDistanceBetweenRobots(GoalTask):
    """Keep every pair of members at a fixed distance within tolerance."""

    fixed_distance: float
    tolerance: float


@kernel
def violated(view: State, g: int) -> bool:
    """Return whether a pair of members differs from the distance by more than the tolerance."""
    goal = view.goals[g]
    last = goal.first_member + goal.n_members
    for m in range(goal.first_member, last):
        robot = view.robots[view.members[m].robot]
        for other in range(m + 1, last):
            second = view.robots[view.members[other].robot]
            gap = distance(robot.x, robot.y, second.x, second.y)
            if excess(abs(gap - goal.distance), goal.tolerance) > 0.0:
                return True
    return False


@kernel
def margin(world: State, g: int, least: float) -> tuple[float, int]:
    """Return the tolerance minus the largest deviation of a pair from the distance."""
    goal = world.goals[g]
    last = goal.first_member + goal.n_members
    most = 0.0
    for m in range(goal.first_member, last):
        robot = world.robots[world.members[m].robot]
        for other in range(m + 1, last):
            second = world.robots[world.members[other].robot]
            gap = distance(robot.x, robot.y, second.x, second.y)
            most = max(most, abs(gap - goal.distance))
    left = goal.tolerance - most
    return left, patience(left, least, 2.0 * world.longest[g])


@kernel
def react(ci: State, g: int) -> None:
    """Let each member correct its gap to the member before it, or else take the same heading."""
    goal = ci.goals[g]
    for m in range(goal.first_member + 1, goal.first_member + goal.n_members):
        first = ci.members[m - 1].robot
        index = ci.members[m].robot
        leader = ci.robots[first]
        robot = ci.robots[index]
        dx, dy = leader.x - robot.x, leader.y - robot.y
        gap = math.sqrt(dx * dx + dy * dy)
        slack = 0.5 * goal.tolerance
        if excess(gap - goal.distance, slack) > 0.0:
            steer(ci, index, dx, dy)
        elif excess(goal.distance - gap, slack) > 0.0:
            steer(ci, index, -dx, -dy)
        else:
            steer(ci, index, ci.commands[first].heading_x, ci.commands[first].heading_y)
