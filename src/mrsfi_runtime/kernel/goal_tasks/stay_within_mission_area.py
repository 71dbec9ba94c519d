"""StayWithinMissionArea: every member stays inside the mission area."""

from dataclasses import dataclass

from mrsfi_runtime.kernel.commands import steer
from mrsfi_runtime.kernel.geometry import distance, inside, well_inside
from mrsfi_runtime.kernel.goal_tasks.common import kth_best, patience, too_many
from mrsfi_runtime.kernel.guidance import leeway, pace
from mrsfi_runtime.kernel.state import GoalState, State, kernel
from mrsfi_runtime.model.mission import GoalTask


@dataclass(frozen=True, slots=True)
class StayWithinMissionArea(GoalTask):
    """Keep every member inside the mission area."""


@kernel
def is_outside(view: State, goal: GoalState, m: int) -> bool:  # noqa: ARG001 - as of all rules
    """Return whether a member is farther from the mission's centre than its radius."""
    robot, mission = view.robots[view.members[m].robot], view.mission
    return not inside(robot.x, robot.y, mission.x, mission.y, mission.radius)


@kernel
def depth(world: State, goal: GoalState, m: int) -> float:  # noqa: ARG001 - as of all values
    """Return how far inside the mission area a member is."""
    robot, mission = world.robots[world.members[m].robot], world.mission
    return mission.radius - distance(robot.x, robot.y, mission.x, mission.y)


violated = too_many(is_outside)
decisive = kth_best(depth)


@kernel
def margin(world: State, g: int, least: float) -> tuple[float, int]:
    """Return how far inside the outermost required member is, and when that can be less."""
    left = decisive(world, g)
    if left <= least:
        return left, 1
    return left, patience(left, least, world.longest[g])


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
        if not well_inside(x, y, mission.x, mission.y, mission.radius, leeway(ci, index)):
            steer(ci, index, mission.x - robot.x, mission.y - robot.y)
