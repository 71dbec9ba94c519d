"""StayWithinMissionArea: every member stays inside the mission area."""

import math
from dataclasses import dataclass

from mrsfi_runtime.kernel.commands import steer
from mrsfi_runtime.kernel.geometry import inside, well_inside
from mrsfi_runtime.kernel.goal_tasks.common import patience, top_speed
from mrsfi_runtime.kernel.guidance import pace
from mrsfi_runtime.kernel.state import State, kernel
from mrsfi_runtime.model.mission import GoalTask


@dataclass(frozen=True, slots=True)
class StayWithinMissionArea(GoalTask):
    """Keep every member inside the mission area."""


@kernel
def violated(view: State, g: int) -> bool:
    """Return whether a member is farther from the mission's centre than its radius."""
    goal = view.goals[g]
    mission = view.mission
    for m in range(goal.first_member, goal.first_member + goal.n_members):
        robot = view.robots[view.members[m].robot]
        if not inside(robot.x, robot.y, mission.x, mission.y, mission.radius):
            return True
    return False


@kernel
def margin(world: State, g: int, least: float) -> tuple[float, int]:
    """Return how far inside the outermost member is, and when that can be below ``least``."""
    goal = world.goals[g]
    mission = world.mission
    square = 0.0
    for m in range(goal.first_member, goal.first_member + goal.n_members):
        robot = world.robots[world.members[m].robot]
        dx, dy = robot.x - mission.x, robot.y - mission.y
        square = max(square, dx * dx + dy * dy)
    left = mission.radius - math.sqrt(square)
    if left <= least:
        return left, 1
    return left, patience(left, least, top_speed(world, goal))


@kernel
def react(ci: State, g: int) -> None:
    """Turn every member that is outside the mission area, or about to leave it, to its centre."""
    goal = ci.goals[g]
    mission = ci.mission
    for m in range(goal.first_member, goal.first_member + goal.n_members):
        index = ci.members[m].robot
        robot = ci.robots[index]
        command = ci.commands[index]
        step = 2.0 * pace(ci, index)
        x, y = robot.x + step * command.heading_x, robot.y + step * command.heading_y
        if not well_inside(x, y, mission.x, mission.y, mission.radius):
            steer(ci, index, mission.x - robot.x, mission.y - robot.y)
