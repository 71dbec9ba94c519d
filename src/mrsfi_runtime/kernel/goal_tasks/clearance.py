"""How near a robot will come to others and to obstacles within the next ticks."""

import math

from mrsfi_runtime.kernel.compiling import kernel
from mrsfi_runtime.kernel.guidance import pace
from mrsfi_runtime.kernel.obstacles import cell_at, is_displaced, is_listed
from mrsfi_runtime.kernel.state import GoalState, State
from mrsfi_runtime.model.mission import ROBOT_RADIUS

LOOK_AHEAD = 10
"""Ticks for which a collision is foreseen."""

MARGIN = 1.0
"""Clearance below which a meeting counts as a coming collision, in distance units."""


@kernel
def sight(ci: State, index: int, limit: float, farthest: float) -> float:
    """Return the distance from which on another robot cannot come nearer than a gap.

    Parameters
    ----------
    ci, index
        Local state, and the index of a robot.
    limit
        The gap.
    farthest
        What any other robot moves within the look-ahead, at most.
    """
    return limit + LOOK_AHEAD * pace(ci, index) + farthest + 2.0 * ROBOT_RADIUS


@kernel
def clearance(
    ci: State, goal: GoalState, index: int, n_near: int, x: float, y: float, limit: float
) -> float:
    """Return the least gap to robots nearby and a goal's obstacles within the look-ahead.

    Parameters
    ----------
    ci, goal, index
        Local state, an AvoidCollision goal, and the index of the robot.
    n_near
        Number of robots in ``ci.lookup.nearby`` that may come nearer than ``limit``.
    x, y
        Unit vector of the heading to judge.
    limit
        Gap beyond which nothing counts; returned when nothing is nearer.

    Notes
    -----
    Obstacles stand still, other robots keep their commanded heading and pace.
    """
    robot = ci.robots[index]
    step = pace(ci, index)
    least = clearance_of_obstacles(ci, goal, index, step * x, step * y, limit)
    for k in range(n_near):
        other = ci.lookup.nearby[k]
        dx = ci.robots[other].x - robot.x
        dy = ci.robots[other].y - robot.y
        other_step = pace(ci, other)
        near = least + LOOK_AHEAD * (step + other_step) + 2.0 * ROBOT_RADIUS
        if abs(dx) < near and abs(dy) < near:
            command = ci.commands[other]
            vx = other_step * command.heading_x - step * x
            vy = other_step * command.heading_y - step * y
            least = min(least, closest(dx, dy, vx, vy) - 2.0 * ROBOT_RADIUS)
    return least


@kernel
def clearance_of_obstacles(
    ci: State, goal: GoalState, index: int, vx: float, vy: float, limit: float
) -> float:
    """Return the least gap to a goal's obstacles, for a robot of given velocity; as ``clearance``.

    Where the map does not reach as far as the robot may move, all obstacles are looked at.
    """
    robot = ci.robots[index]
    reach = limit + LOOK_AHEAD * pace(ci, index) + ROBOT_RADIUS
    is_mapped = reach <= ci.map.reach
    least = limit
    if is_mapped:
        cell = cell_at(ci, robot.x, robot.y)
        for k in range(ci.cells[cell], ci.cells[cell + 1]):
            mapped = ci.mapped[k]
            if mapped.gap >= reach:
                break
            gap = gap_to_obstacle(ci, index, mapped.obstacle, vx, vy, reach)
            if gap < least and is_listed(ci, goal, mapped.obstacle):
                least = gap
        if ci.map.is_wrong == 0:
            return least
    for h in range(goal.first_hazard, goal.first_hazard + goal.n_hazards):
        if not is_mapped or is_displaced(ci, ci.hazards[h]):
            least = min(least, gap_to_obstacle(ci, index, ci.hazards[h], vx, vy, reach))
    return least


@kernel
def gap_to_obstacle(
    ci: State, index: int, hazard: int, vx: float, vy: float, reach: float
) -> float:
    """Return the gap to an obstacle within the look-ahead, or ``reach`` if it is too far away.

    Parameters
    ----------
    ci, index, hazard
        Local state, and the indices of the robot and the obstacle.
    vx, vy
        What the robot moves in a tick.
    reach
        Distance from the obstacle's edge beyond which nothing counts.
    """
    robot = ci.robots[index]
    obstacle = ci.obstacles[hazard]
    dx = obstacle.x - robot.x
    dy = obstacle.y - robot.y
    near = reach + obstacle.radius
    if abs(dx) >= near or abs(dy) >= near:
        return reach
    return closest(dx, dy, -vx, -vy) - obstacle.radius - ROBOT_RADIUS


@kernel
def closest(dx: float, dy: float, vx: float, vy: float) -> float:
    """Return the least distance of a moving point from the origin in ticks 1 … LOOK_AHEAD."""
    square = vx * vx + vy * vy
    when = 1.0
    if square > 0.0:
        when = min(max(-(dx * vx + dy * vy) / square, 1.0), float(LOOK_AHEAD))
    x = dx + when * vx
    y = dy + when * vy
    return math.sqrt(x * x + y * y)
