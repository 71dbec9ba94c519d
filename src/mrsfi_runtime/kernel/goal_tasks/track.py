"""Track: every member follows a trajectory."""

from dataclasses import dataclass

from mrsfi_runtime.kernel.commands import set_speed
from mrsfi_runtime.kernel.geometry import inside
from mrsfi_runtime.kernel.goal_tasks.common import NO_MARGIN, kth_best, too_many
from mrsfi_runtime.kernel.guidance import approach, is_surely_at
from mrsfi_runtime.kernel.state import GoalState, State, excess, kernel
from mrsfi_runtime.model.mission import Coordinates, GoalTask
from mrsfi_runtime.model.polygons import off_segment


@dataclass(frozen=True, slots=True)
class Track(GoalTask):
    """Have every member follow a trajectory within tolerance."""

    trajectory: tuple[Coordinates, ...]
    tolerance: float


@kernel
def progress(view: State, g: int) -> None:
    """Advance every member's next waypoint past those it is within tolerance of."""
    goal = view.goals[g]
    for m in range(goal.first_member, goal.first_member + goal.n_members):
        member = view.members[m]
        robot = view.robots[member.robot]
        while member.waypoint < goal.n_waypoints:
            point = view.waypoints[goal.first_waypoint + member.waypoint]
            if not inside(robot.x, robot.y, point.x, point.y, goal.tolerance):
                break
            member.waypoint += 1


@kernel
def off_track(view: State, goal: GoalState, m: int) -> float:
    """Return the distance of a member from its current segment; -1 if it has none.

    Before the first waypoint and after the last there is no current segment.
    """
    member = view.members[m]
    if not 0 < member.waypoint < goal.n_waypoints:
        return -1.0
    robot = view.robots[member.robot]
    start = view.waypoints[goal.first_waypoint + member.waypoint - 1]
    end = view.waypoints[goal.first_waypoint + member.waypoint]
    return off_segment(robot.x - start.x, robot.y - start.y, end.x - start.x, end.y - start.y)


@kernel
def has_strayed(view: State, goal: GoalState, m: int) -> bool:
    """Return whether a member is off its current segment by more than the tolerance."""
    return excess(off_track(view, goal, m), goal.tolerance) > 0.0


@kernel
def has_more(view: State, goal: GoalState, m: int) -> bool:
    """Return whether a member has not reached its last waypoint yet."""
    return view.members[m].waypoint < goal.n_waypoints


@kernel
def slack(world: State, goal: GoalState, m: int) -> float:
    """Return the tolerance minus a member's distance from its current segment."""
    off = off_track(world, goal, m)
    return NO_MARGIN if off < 0.0 else goal.tolerance - off


violated = too_many(has_strayed)
is_unfinished = too_many(has_more)
decisive = kth_best(slack)


@kernel
def margin(world: State, g: int, least: float) -> tuple[float, int]:  # noqa: ARG001 - as of all tasks
    """Return the least slack of a required member, to be computed at every tick."""
    return decisive(world, g), 1


@kernel
def next_aim(ci: State, goal: GoalState, m: int) -> int:
    """Return the waypoint that a member heads for: its next one, or one that it may have missed."""
    member = ci.members[m]
    if ci.traits[member.robot].position_noise <= 0.0:
        return member.waypoint
    while ci.aims[m] < member.waypoint:
        point = ci.waypoints[goal.first_waypoint + ci.aims[m]]
        if not is_surely_at(ci, member.robot, point.x, point.y, goal.tolerance):
            break
        ci.aims[m] += 1
    return ci.aims[m]


@kernel
def react(ci: State, g: int) -> None:
    """Head for every member's next waypoint, with a last step no longer than needed."""
    goal = ci.goals[g]
    for m in range(goal.first_member, goal.first_member + goal.n_members):
        member, aim = ci.members[m], next_aim(ci, goal, m)
        if aim < goal.n_waypoints:
            point = ci.waypoints[goal.first_waypoint + aim]
            approach(ci, member.robot, point.x, point.y)
        else:
            set_speed(ci, member.robot, ci.robots[member.robot].nominal_speed)
