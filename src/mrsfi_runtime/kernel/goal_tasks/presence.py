"""Which members have been in the area of a goal, or at its point, and when; how they get there."""

from mrsfi_runtime.kernel.compiling import kernel
from mrsfi_runtime.kernel.geometry import distance, inside
from mrsfi_runtime.kernel.guidance import roam_together
from mrsfi_runtime.kernel.state import GoalState, RobotState, State


@kernel
def note_presence(view: State, g: int) -> None:
    """Note which members are inside the goal's area, or within tolerance of its point."""
    goal = view.goals[g]
    for m in range(goal.first_member, goal.first_member + goal.n_members):
        member = view.members[m]
        robot = view.robots[member.robot]
        if inside(robot.x, robot.y, goal.x, goal.y, goal.radius + goal.tolerance):
            member.since = view.mission.tick
            member.reached = 1


@kernel
def depth(goal: GoalState, robot: RobotState) -> float:
    """Return how far inside the goal's area, or within tolerance of its point, a robot is."""
    return goal.radius + goal.tolerance - distance(robot.x, robot.y, goal.x, goal.y)


@kernel
def is_awaited(view: State, g: int) -> bool:
    """Return whether a member has not been there yet."""
    goal = view.goals[g]
    for m in range(goal.first_member, goal.first_member + goal.n_members):
        if view.members[m].reached == 0:
            return True
    return False


@kernel
def roam_area(ci: State, g: int) -> None:
    """Head for the area from outside, roam inside it."""
    roam_together(ci, ci.goals[g])
