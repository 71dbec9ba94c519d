"""Where the reference collective intelligence sends a robot: to a place, or around inside one."""

from mrsfi_runtime.kernel.commands import set_speed, steer
from mrsfi_runtime.kernel.compiling import kernel
from mrsfi_runtime.kernel.geometry import distance, inside
from mrsfi_runtime.kernel.randomness import PURPOSE_ROAM, choice
from mrsfi_runtime.kernel.state import GoalState, State

ROAM_ATTEMPTS = 8
"""Headings that a roaming robot draws before it turns to the middle of its area."""


@kernel
def pace(ci: State, index: int) -> float:
    """Return the distance that a robot may move in a tick, as far as is known."""
    return max(ci.commands[index].speed, ci.robots[index].nominal_speed)


@kernel
def approach(ci: State, index: int, x: float, y: float) -> None:
    """Head for a point at nominal speed, slower only for the last step."""
    robot = ci.robots[index]
    steer(ci, index, x - robot.x, y - robot.y)
    set_speed(ci, index, min(robot.nominal_speed, distance(robot.x, robot.y, x, y)))


@kernel
def roam(ci: State, goal: GoalState, index: int) -> None:
    """Head for a goal's area from outside; inside, turn by chance before leaving it."""
    robot = ci.robots[index]
    if not inside(robot.x, robot.y, goal):
        steer(ci, index, goal.x - robot.x, goal.y - robot.y)
        return
    step = pace(ci, index)
    command = ci.commands[index]
    if inside(robot.x + step * command.heading_x, robot.y + step * command.heading_y, goal):
        return
    mission = ci.mission
    for attempt in range(ROAM_ATTEMPTS):
        entity = index * ROAM_ATTEMPTS + attempt
        degrees = choice(len(ci.directions), mission.seed, mission.tick, entity, PURPOSE_ROAM)
        turn = ci.directions[degrees]
        if inside(robot.x + 2.0 * step * turn.x, robot.y + 2.0 * step * turn.y, goal):
            steer(ci, index, turn.x, turn.y)
            return
    steer(ci, index, goal.x - robot.x, goal.y - robot.y)


@kernel
def roam_together(ci: State, goal: GoalState) -> None:
    """Let every member of a goal roam its area."""
    for m in range(goal.first_member, goal.first_member + goal.n_members):
        roam(ci, goal, ci.members[m].robot)
