"""Functions that goal tasks share: margins, and which members have been in a goal's area.

A margin is the distance from violation, in the unit of the goal's task; it is negative if the goal
is violated. Robot motion bounds how fast most margins change. ``patience`` uses this bound to tell
for how many ticks a margin need not be computed, as it cannot fall below the least so far.

References
----------
Margins are the robustness of signal temporal logic (A. Donzé and O. Maler, "Robust Satisfaction of
Temporal Logic over Real-Valued Signals", FORMATS 2010), taken as the minimum over a flight.
"""

import math
from typing import Final

from mrsfi_runtime.kernel.geometry import distance, inside
from mrsfi_runtime.kernel.guidance import roam
from mrsfi_runtime.kernel.state import GoalState, RobotState, State, kernel

NO_MARGIN: Final = math.inf
"""Margin of a goal while it is undefined, such as before a robot first enters its area."""

NEVER: Final = 1 << 40  # a tick that no mission reaches


@kernel
def patience(left: float, least: float, speed: float) -> int:
    """Return after how many ticks a margin, now ``left``, can be below ``least``; at least 1.

    ``speed`` is the most that the margin falls in a tick.
    """
    spare = left - least
    if spare <= speed:
        return 1
    return NEVER if spare >= NEVER * speed else int(spare / speed)


@kernel
def top_speed(view: State, goal: GoalState) -> float:
    """Return the distance that any member of a goal can move in a tick."""
    most = 0.0
    for m in range(goal.first_member, goal.first_member + goal.n_members):
        most = max(most, view.robots[view.members[m].robot].max_speed)
    return most


@kernel
def note_presence(view: State, g: int) -> None:
    """Record which members are inside the goal's area, or within tolerance of its point."""
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
    """Return whether a member has not yet been at the goal's area or point."""
    goal = view.goals[g]
    for m in range(goal.first_member, goal.first_member + goal.n_members):
        if view.members[m].reached == 0:
            return True
    return False


@kernel
def roam_area(ci: State, g: int) -> None:
    """Let every member head for the area from outside, and roam inside it."""
    goal = ci.goals[g]
    for m in range(goal.first_member, goal.first_member + goal.n_members):
        roam(ci, goal, ci.members[m].robot)
