"""AvoidCollision: the discs of robots and obstacles keep a clearance, and never overlap.

A gap is the distance of two centres minus both radii and the clearance; the goal is violated while
one is below 0. Checks and margins compare the distances of one tick. Reactions look ``LOOK_AHEAD``
ticks ahead, as if all robots kept heading and speed. ``kernel.neighbours`` finds those near enough
to matter, so that few pairs are compared; the results equal those of comparing all pairs.

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
from mrsfi_runtime.model.mission import GoalTask

LOOK_AHEAD = 10  # ticks for which a collision is foreseen

SURE = 1.0 + 1e-9  # factor that exceeds every rounding error of a square

HORIZON = 4
"""Ticks for which a robot need not be checked again, if it is far enough from all others."""

CANDIDATE_STEP = 15  # degrees between the candidate headings of an evading robot


@dataclass(frozen=True, slots=True)
class AvoidCollision(GoalTask):
    """Keep robots (by ID) clear of each other and of obstacles (by ID), by a gap >= 0."""

    robots: tuple[str, ...]
    obstacles: tuple[str, ...] = ()
    clearance: float = 0.0


@kernel
def violated(view: State, g: int) -> bool:
    """Return whether two discs are too near among a goal's robots and obstacles."""
    return hits_obstacle(view, view.goals[g]) or hits_robot(view, g)


@kernel
def size(view: State, goal: GoalState, index: int) -> float:
    """Return the radius of a robot plus the clearance."""
    return view.traits[index].radius + goal.distance


@kernel
def hits_obstacle(view: State, goal: GoalState) -> bool:
    """Return whether a disc of a goal's robots is too near to one of its obstacles."""
    for m in range(goal.first_member, goal.first_member + goal.n_members):
        robot = view.robots[view.members[m].robot]
        own = size(view, goal, view.members[m].robot)
        cell = cell_at(view, robot.x, robot.y)
        for k in range(view.cells[cell], view.cells[cell + 1]):
            mapped = view.mapped[k]
            if mapped.gap >= own:
                break
            index = mapped.obstacle
            if hits(view, robot.x, robot.y, own, index) and is_listed(view, goal, index):
                return True
    return view.map.is_wrong == 1 and hits_displaced(view, goal)


@kernel
def hits_displaced(view: State, goal: GoalState) -> bool:
    """Return whether a robot is too near to an obstacle that is off its model position."""
    for h in range(goal.first_hazard, goal.first_hazard + goal.n_hazards):
        if is_displaced(view, view.hazards[h]):
            for m in range(goal.first_member, goal.first_member + goal.n_members):
                robot = view.robots[view.members[m].robot]
                own = size(view, goal, view.members[m].robot)
                if hits(view, robot.x, robot.y, own, view.hazards[h]):
                    return True
    return False


@kernel
def hits(view: State, x: float, y: float, own: float, index: int) -> bool:
    """Return whether a robot of a ``size`` at a point is too near to an obstacle."""
    obstacle = view.obstacles[index]
    return overlap(obstacle.x - x, obstacle.y - y, obstacle.radius + own)


@kernel
def hits_robot(view: State, g: int) -> bool:
    """Return whether two discs of a goal's robots are too near to each other."""
    goal = view.goals[g]
    last = goal.first_member + goal.n_members
    if goal.n_members > FEW:
        return hits_neighbour(view, goal, view.apart[g])
    for m in range(goal.first_member, last):
        index = view.members[m].robot
        x, y, own = view.robots[index].x, view.robots[index].y, size(view, goal, index)
        for n in range(m + 1, last):
            other = view.members[n].robot
            second = view.robots[other]
            if overlap(second.x - x, second.y - y, own + view.traits[other].radius):
                return True
    return False


@kernel
def hits_neighbour(view: State, goal: GoalState, apart: float) -> bool:
    """Return whether two of many robots, of which none beyond ``apart`` count, are too near."""
    chart(view, goal, apart)
    for m in range(goal.first_member, goal.first_member + goal.n_members):
        index = view.members[m].robot
        robot, own = view.robots[index], size(view, goal, index)
        for k in range(gather(view, goal, index, apart)):
            other = view.lookup.nearby[k]
            second = view.robots[other]
            both = own + view.traits[other].radius
            if overlap(second.x - robot.x, second.y - robot.y, both):
                return True
    return False


@kernel
def margin(world: State, g: int, least: float) -> tuple[float, int]:
    """Return the least gap between two discs, and when one can be below ``least``."""
    goal = world.goals[g]
    to_obstacle = gap_to_obstacles(world, goal)
    speed = top_speed(world, goal)
    to_robot = gap_between_robots(world, g, max(least, 0.0) + HORIZON * speed)
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
        own = size(world, goal, world.members[m].robot)
        cell = cell_at(world, robot.x, robot.y)
        for k in range(world.cells[cell], world.cells[cell + 1]):
            mapped = world.mapped[k]
            if mapped.gap - own >= least:
                break
            gap = gap_to(world, robot.x, robot.y, own, mapped.obstacle, least)
            if gap < least and is_listed(world, goal, mapped.obstacle):
                least = gap
        if least > world.map.reach - own:  # no cell lists obstacles beyond
            for h in range(goal.first_hazard, goal.first_hazard + goal.n_hazards):
                least = gap_to(world, robot.x, robot.y, own, world.hazards[h], least)
    return least


@kernel
def gap_to(view: State, x: float, y: float, own: float, index: int, limit: float) -> float:
    """Return the gap between a robot of a ``size`` at a point and an obstacle, or ``limit``."""
    obstacle = view.obstacles[index]
    dx, dy = obstacle.x - x, obstacle.y - y
    square = dx * dx + dy * dy
    both = obstacle.radius + own
    if square >= (limit + both) * (limit + both):
        return limit
    return math.sqrt(square) - both


@kernel
def gap_between_robots(world: State, g: int, limit: float) -> float:
    """Return the least gap between two robots; of more than ``FEW`` robots, at most ``limit``.

    A square root is taken only where the gap may be less than those before.
    """
    goal = world.goals[g]
    last = goal.first_member + goal.n_members
    if goal.n_members > FEW:
        return gap_between_neighbours(world, goal, world.apart[g], limit)
    least = NO_MARGIN
    for m in range(goal.first_member, last):
        index = world.members[m].robot
        x, y, own = world.robots[index].x, world.robots[index].y, size(world, goal, index)
        for n in range(m + 1, last):
            other = world.members[n].robot
            dx, dy = world.robots[other].x - x, world.robots[other].y - y
            both = own + world.traits[other].radius
            square = dx * dx + dy * dy
            if square < (least + both) * (least + both) * SURE:
                least = min(least, math.sqrt(square) - both)
    return least


@kernel
def gap_between_neighbours(world: State, goal: GoalState, apart: float, limit: float) -> float:
    """Return the least gap between two of more than ``FEW`` robots, at most ``limit``.

    No two robots beyond ``apart`` have a gap below 0.
    """
    least = limit
    chart(world, goal, apart)
    for m in range(goal.first_member, goal.first_member + goal.n_members):
        index = world.members[m].robot
        robot, own = world.robots[index], size(world, goal, index)
        for k in range(gather(world, goal, index, apart + least)):
            other = world.lookup.nearby[k]
            second = world.robots[other]
            both = own + world.traits[other].radius
            least = min(least, distance(robot.x, robot.y, second.x, second.y) - both)
    return least


@kernel
def react(ci: State, g: int) -> None:
    """Turn every member whose gap will soon be below its radius to the heading with the widest."""
    goal = ci.goals[g]
    farthest = LOOK_AHEAD * fastest(ci, goal)
    chart(ci, goal, 0.5 * ci.apart[g] + 2.0 * farthest + ci.apart[g])
    for m in range(goal.first_member, goal.first_member + goal.n_members):
        index = ci.members[m].robot
        command = ci.commands[index]
        least = ci.traits[index].radius
        n_near = gather(ci, goal, index, sight(ci, g, index, least, farthest))
        x, y = command.heading_x, command.heading_y
        if excess(gap_along(ci, goal, index, n_near, x, y, least), least) < 0.0:
            evade(ci, g, index, farthest)


@kernel
def evade(ci: State, g: int, index: int, farthest: float) -> None:
    """Steer a robot to the heading with the widest gap that keeps it in the mission area.

    A later heading wins only if its gap is wider by more than ``TOLERANCE``.
    """
    goal = ci.goals[g]
    robot = ci.robots[index]
    reach = LOOK_AHEAD * pace(ci, index)
    limit = 2.0 * reach
    n_near = gather(ci, goal, index, sight(ci, g, index, limit, farthest))
    best = -1
    most = 0.0
    for degrees in range(0, len(ci.directions), CANDIDATE_STEP):
        heading = ci.directions[degrees]
        mission = ci.mission
        x, y = robot.x + reach * heading.x, robot.y + reach * heading.y
        if well_inside(x, y, mission.x, mission.y, mission.radius):
            gap = gap_along(ci, goal, index, n_near, heading.x, heading.y, limit)
            if best < 0 or gap > most + TOLERANCE:
                best = degrees
                most = gap
    if best >= 0:
        steer(ci, index, ci.directions[best].x, ci.directions[best].y)


@kernel
def sight(ci: State, g: int, index: int, limit: float, farthest: float) -> float:
    """Return the distance beyond which another robot's gap cannot fall below ``limit``.

    ``farthest`` is the most that any other robot moves within the look-ahead.
    """
    return limit + LOOK_AHEAD * pace(ci, index) + farthest + ci.apart[g]


@kernel
def gap_along(
    ci: State, goal: GoalState, index: int, n_near: int, x: float, y: float, limit: float
) -> float:
    """Return the least gap to robots nearby and a goal's obstacles within the look-ahead.

    Only the first ``n_near`` robots in ``ci.lookup.nearby`` can come nearer than ``limit``,
    which is returned if no gap is smaller. ``x`` and ``y`` are the unit vector of the candidate
    heading. Obstacles stand still, and other robots keep their commanded heading and speed.
    """
    robot = ci.robots[index]
    step = pace(ci, index)
    least = gap_to_obstacles_along(ci, goal, index, step * x, step * y, limit)
    own = size(ci, goal, index)
    for k in range(n_near):
        other = ci.lookup.nearby[k]
        dx, dy = ci.robots[other].x - robot.x, ci.robots[other].y - robot.y
        other_step = pace(ci, other)
        both = own + ci.traits[other].radius
        near = least + LOOK_AHEAD * (step + other_step) + both
        if abs(dx) < near and abs(dy) < near:
            command = ci.commands[other]
            vx = other_step * command.heading_x - step * x
            vy = other_step * command.heading_y - step * y
            least = min(least, closest(dx, dy, vx, vy) - both)
    return least


@kernel
def gap_to_obstacles_along(
    ci: State, goal: GoalState, index: int, vx: float, vy: float, limit: float
) -> float:
    """Return the least gap to a goal's obstacles, for a given velocity; as ``gap_along``.

    If the map does not reach as far as the robot may move, all obstacles are checked.
    """
    robot, own = ci.robots[index], size(ci, goal, index)
    reach = limit + LOOK_AHEAD * pace(ci, index) + own
    is_mapped = reach <= ci.map.reach
    least = limit
    if is_mapped:
        cell = cell_at(ci, robot.x, robot.y)
        for k in range(ci.cells[cell], ci.cells[cell + 1]):
            mapped = ci.mapped[k]
            if mapped.gap >= reach:
                break
            gap = gap_to_obstacle(ci, index, own, mapped.obstacle, vx, vy, reach)
            if gap < least and is_listed(ci, goal, mapped.obstacle):
                least = gap
        if ci.map.is_wrong == 0:
            return least
    for h in range(goal.first_hazard, goal.first_hazard + goal.n_hazards):
        if not is_mapped or is_displaced(ci, ci.hazards[h]):
            least = min(least, gap_to_obstacle(ci, index, own, ci.hazards[h], vx, vy, reach))
    return least


@kernel
def gap_to_obstacle(
    ci: State, index: int, own: float, hazard: int, vx: float, vy: float, reach: float
) -> float:
    """Return the gap to an obstacle within the look-ahead, or ``reach`` if it is too far away.

    ``own`` is the robot's ``size``, ``vx`` and ``vy`` its motion in a tick. A gap counts only
    within ``reach`` of the obstacle's edge.
    """
    robot = ci.robots[index]
    obstacle = ci.obstacles[hazard]
    dx, dy = obstacle.x - robot.x, obstacle.y - robot.y
    near = reach + obstacle.radius
    if abs(dx) >= near or abs(dy) >= near:
        return reach
    return closest(dx, dy, -vx, -vy) - obstacle.radius - own


@kernel
def closest(dx: float, dy: float, vx: float, vy: float) -> float:
    """Return the least distance of a moving point from the origin in ticks 1 … LOOK_AHEAD."""
    square = vx * vx + vy * vy
    when = 1.0
    if square > 0.0:
        when = min(max(-(dx * vx + dy * vy) / square, 1.0), float(LOOK_AHEAD))
    x, y = dx + when * vx, dy + when * vy
    return math.sqrt(x * x + y * y)
