"""AvoidCollision: the discs of robots and obstacles never overlap.

Checks and margins compare the distances of one tick. Reactions look ``LOOK_AHEAD`` ticks ahead, as
if all robots kept heading and speed. ``kernel.neighbours`` finds those near enough to matter, so
that few pairs are compared; the results equal those of comparing all pairs.

Begin with ``violated``, ``margin`` and ``react``; each is followed by the functions that it calls.
"""

import math
from dataclasses import dataclass

from mrsfi_runtime.kernel.commands import steer
from mrsfi_runtime.kernel.geometry import distance, overlap, well_inside
from mrsfi_runtime.kernel.goal_tasks.common import NO_MARGIN, patience, top_speed
from mrsfi_runtime.kernel.guidance import pace
from mrsfi_runtime.kernel.neighbours import (
    FEW,
    cell_at,
    chart,
    fastest,
    gather,
    is_displaced,
    is_listed,
)
from mrsfi_runtime.kernel.state import TOLERANCE, GoalState, State, excess, kernel
from mrsfi_runtime.model.mission import ROBOT_RADIUS, GoalTask

LOOK_AHEAD = 10  # ticks for which a collision is foreseen
MARGIN = 1.0  # clearance below which a meeting counts as a coming collision, in distance units

HORIZON = 4
"""Ticks for which a robot need not be checked again, if it is far enough from all others."""

CANDIDATE_STEP = 15  # degrees between the candidate headings of an evading robot


@dataclass(frozen=True, slots=True)
class AvoidCollision(GoalTask):
    """Keep robots (by ID) clear of each other and of obstacles (by ID)."""

    robots: tuple[str, ...]
    obstacles: tuple[str, ...] = ()


@kernel
def violated(view: State, g: int) -> bool:
    """Return whether two discs overlap among a goal's robots and obstacles."""
    goal = view.goals[g]
    return hits_obstacle(view, goal) or hits_robot(view, goal)


@kernel
def hits_obstacle(view: State, goal: GoalState) -> bool:
    """Return whether a disc of a goal's robots overlaps with one of its obstacles."""
    for m in range(goal.first_member, goal.first_member + goal.n_members):
        robot = view.robots[view.members[m].robot]
        cell = cell_at(view, robot.x, robot.y)
        for k in range(view.cells[cell], view.cells[cell + 1]):
            mapped = view.mapped[k]
            if mapped.gap >= ROBOT_RADIUS:
                break
            index = mapped.obstacle
            if hits(view, robot.x, robot.y, index) and is_listed(view, goal, index):
                return True
    return view.map.is_wrong == 1 and hits_displaced(view, goal)


@kernel
def hits_displaced(view: State, goal: GoalState) -> bool:
    """Return whether a robot's disc overlaps with an obstacle that is off its model position."""
    for h in range(goal.first_hazard, goal.first_hazard + goal.n_hazards):
        if is_displaced(view, view.hazards[h]):
            for m in range(goal.first_member, goal.first_member + goal.n_members):
                robot = view.robots[view.members[m].robot]
                if hits(view, robot.x, robot.y, view.hazards[h]):
                    return True
    return False


@kernel
def hits(view: State, x: float, y: float, index: int) -> bool:
    """Return whether the disc of a robot at a point overlaps with that of an obstacle."""
    obstacle = view.obstacles[index]
    return overlap(obstacle.x - x, obstacle.y - y, obstacle.radius + ROBOT_RADIUS)


@kernel
def hits_robot(view: State, goal: GoalState) -> bool:
    """Return whether two discs of a goal's robots overlap."""
    both = 2.0 * ROBOT_RADIUS
    last = goal.first_member + goal.n_members
    if goal.n_members > FEW:
        return hits_neighbour(view, goal, both)
    for m in range(goal.first_member, last):
        robot = view.robots[view.members[m].robot]
        x, y = robot.x, robot.y
        for other in range(m + 1, last):
            second = view.robots[view.members[other].robot]
            if overlap(second.x - x, second.y - y, both):
                return True
    return False


@kernel
def hits_neighbour(view: State, goal: GoalState, both: float) -> bool:
    """Return whether two of many robots are nearer to each other than a distance."""
    chart(view, goal, both)
    for m in range(goal.first_member, goal.first_member + goal.n_members):
        index = view.members[m].robot
        robot = view.robots[index]
        for k in range(gather(view, goal, index, both)):
            other = view.robots[view.lookup.nearby[k]]
            if overlap(other.x - robot.x, other.y - robot.y, both):
                return True
    return False


@kernel
def margin(world: State, g: int, least: float) -> tuple[float, int]:
    """Return the least gap between two discs, and when a gap can be below ``least``."""
    goal = world.goals[g]
    to_obstacle = gap_to_obstacles(world, goal)
    speed = top_speed(world, goal)
    to_robot = gap_between_robots(world, goal, max(least, 0.0) + HORIZON * speed)
    left = min(to_obstacle, to_robot)
    if left <= least:
        return left, 1
    return left, min(patience(to_obstacle, least, speed), patience(to_robot, least, 2.0 * speed))


@kernel
def gap_to_obstacles(world: State, goal: GoalState) -> float:
    """Return the least gap between robots and obstacles of a goal, at their model positions."""
    least = NO_MARGIN
    for m in range(goal.first_member, goal.first_member + goal.n_members):
        robot = world.robots[world.members[m].robot]
        cell = cell_at(world, robot.x, robot.y)
        for k in range(world.cells[cell], world.cells[cell + 1]):
            mapped = world.mapped[k]
            if mapped.gap - ROBOT_RADIUS >= least:
                break
            gap = gap_to(world, robot.x, robot.y, mapped.obstacle, least)
            if gap < least and is_listed(world, goal, mapped.obstacle):
                least = gap
        if least > world.map.reach - ROBOT_RADIUS:  # no cell lists obstacles beyond
            for h in range(goal.first_hazard, goal.first_hazard + goal.n_hazards):
                least = gap_to(world, robot.x, robot.y, world.hazards[h], least)
    return least


@kernel
def gap_to(view: State, x: float, y: float, index: int, limit: float) -> float:
    """Return the gap between a robot's disc at a point and an obstacle's, at most ``limit``."""
    obstacle = view.obstacles[index]
    dx, dy = obstacle.x - x, obstacle.y - y
    square = dx * dx + dy * dy
    both = obstacle.radius + ROBOT_RADIUS
    if square >= (limit + both) * (limit + both):
        return limit
    return math.sqrt(square) - both


@kernel
def gap_between_robots(world: State, goal: GoalState, limit: float) -> float:
    """Return the least gap between two robots; of more than ``FEW`` robots, at most ``limit``."""
    both = 2.0 * ROBOT_RADIUS
    last = goal.first_member + goal.n_members
    if goal.n_members > FEW:
        return gap_between_neighbours(world, goal, limit)
    square = NO_MARGIN
    for m in range(goal.first_member, last):
        robot = world.robots[world.members[m].robot]
        x, y = robot.x, robot.y
        for other in range(m + 1, last):
            second = world.robots[world.members[other].robot]
            dx, dy = second.x - x, second.y - y
            square = min(square, dx * dx + dy * dy)
    return math.sqrt(square) - both


@kernel
def gap_between_neighbours(world: State, goal: GoalState, limit: float) -> float:
    """Return the least gap between two of more than ``FEW`` robots, at most ``limit``."""
    both = 2.0 * ROBOT_RADIUS
    least = limit
    chart(world, goal, both)
    for m in range(goal.first_member, goal.first_member + goal.n_members):
        index = world.members[m].robot
        robot = world.robots[index]
        for k in range(gather(world, goal, index, both + least)):
            second = world.robots[world.lookup.nearby[k]]
            least = min(least, distance(robot.x, robot.y, second.x, second.y) - both)
    return least


@kernel
def react(ci: State, g: int) -> None:
    """Turn every member that will soon collide to the heading with the most clearance."""
    goal = ci.goals[g]
    farthest = LOOK_AHEAD * fastest(ci, goal)
    chart(ci, goal, MARGIN + 2.0 * farthest + 2.0 * ROBOT_RADIUS)
    for m in range(goal.first_member, goal.first_member + goal.n_members):
        index = ci.members[m].robot
        command = ci.commands[index]
        n_near = gather(ci, goal, index, sight(ci, index, MARGIN, farthest))
        x, y = command.heading_x, command.heading_y
        gap = clearance(ci, goal, index, n_near, x, y, MARGIN)
        if excess(gap, MARGIN) < 0.0:
            evade(ci, goal, index, farthest)


@kernel
def evade(ci: State, goal: GoalState, index: int, farthest: float) -> None:
    """Steer a robot to the heading with the most clearance that keeps it in the mission area.

    A later heading wins only if its clearance is greater by more than ``TOLERANCE``.
    """
    robot = ci.robots[index]
    reach = LOOK_AHEAD * pace(ci, index)
    limit = 2.0 * reach
    n_near = gather(ci, goal, index, sight(ci, index, limit, farthest))
    best = -1
    most = 0.0
    for degrees in range(0, len(ci.directions), CANDIDATE_STEP):
        heading = ci.directions[degrees]
        mission = ci.mission
        x, y = robot.x + reach * heading.x, robot.y + reach * heading.y
        if well_inside(x, y, mission.x, mission.y, mission.radius):
            clear = clearance(ci, goal, index, n_near, heading.x, heading.y, limit)
            if best < 0 or clear > most + TOLERANCE:
                best = degrees
                most = clear
    if best >= 0:
        steer(ci, index, ci.directions[best].x, ci.directions[best].y)


@kernel
def sight(ci: State, index: int, limit: float, farthest: float) -> float:
    """Return the distance beyond which another robot's gap cannot fall below ``limit``.

    ``farthest`` is the most that any other robot moves within the look-ahead.
    """
    return limit + LOOK_AHEAD * pace(ci, index) + farthest + 2.0 * ROBOT_RADIUS


@kernel
def clearance(
    ci: State, goal: GoalState, index: int, n_near: int, x: float, y: float, limit: float
) -> float:
    """Return the least gap to robots nearby and a goal's obstacles within the look-ahead.

    Only the first ``n_near`` robots in ``ci.lookup.nearby`` can come nearer than ``limit``,
    which is returned if no gap is smaller. ``x`` and ``y`` are the unit vector of the candidate
    heading. Obstacles stand still, and other robots keep their commanded heading and speed.
    """
    robot = ci.robots[index]
    step = pace(ci, index)
    least = clearance_of_obstacles(ci, goal, index, step * x, step * y, limit)
    for k in range(n_near):
        other = ci.lookup.nearby[k]
        dx, dy = ci.robots[other].x - robot.x, ci.robots[other].y - robot.y
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
    """Return the least gap to a goal's obstacles, for a given velocity; as ``clearance``.

    If the map does not reach as far as the robot may move, all obstacles are checked.
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

    ``vx`` and ``vy`` are the robot's motion in a tick. A gap counts only within ``reach`` of the
    obstacle's edge.
    """
    robot = ci.robots[index]
    obstacle = ci.obstacles[hazard]
    dx, dy = obstacle.x - robot.x, obstacle.y - robot.y
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
    x, y = dx + when * vx, dy + when * vy
    return math.sqrt(x * x + y * y)
