"""AvoidCollision: the discs of robots and obstacles keep a clearance, and never overlap.

A gap is the least distance of two centres on their way from the tick before to this one, minus both
radii and the clearance; the goal is violated while one is below 0. In belief, a position that a
fault moves may jump: nothing was on the way, and only its end counts. Reactions look ``LOOK_AHEAD``
ticks ahead, as if all robots kept heading and speed. ``kernel.neighbours`` finds those near enough
to matter, so that few pairs are compared; the results equal those of comparing all pairs. A member
is *calm* for the ticks in which nothing can be so near, however all move (``rouse``); in flights of
the reference engine, and where a team's code may change a state, none is.

Begin with ``violated``, ``margin`` and ``react``; each is followed by the functions that it calls.
"""

import math
from dataclasses import dataclass

from mrsfi_runtime.kernel.commands import steer
from mrsfi_runtime.kernel.geometry import well_inside
from mrsfi_runtime.kernel.goal_tasks.common import (
    AWAKE,
    CALM,
    NEVER,
    is_quiet,
    jumps,
    needs_reaction,
    patience,
)
from mrsfi_runtime.kernel.guidance import berth, leeway, pace
from mrsfi_runtime.kernel.neighbours import (
    FEW,
    SURE,
    cell_at,
    chart,
    gather,
    is_displaced,
    is_listed,
)
from mrsfi_runtime.kernel.state import (
    TOLERANCE,
    AreaState,
    GoalState,
    State,
    excess,
    kernel,
)
from mrsfi_runtime.model.mission import GoalTask
from mrsfi_runtime.model.polygons import off_polygon, off_segment, off_way, square_off

LOOK_AHEAD = 10  # ticks for which a collision is foreseen

HORIZON = 8
"""Ticks for which the margin need not be computed anew, if nothing is near enough.

Of more than ``FEW`` members, some mostly are: their margin is computed at each tick.
"""

LONGEST = 24  # ticks for which a member is calm at most

CANDIDATE_STEP = 15  # degrees between the candidate headings of an evading robot


@dataclass(frozen=True, slots=True)
class AvoidCollision(GoalTask):
    """Keep robots (by ID) clear of each other and of obstacles (by ID), by a gap >= 0."""

    robots: tuple[str, ...]
    obstacles: tuple[str, ...] = ()
    clearance: float = 0.0


@kernel
def violated(view: State, g: int) -> bool:
    """Return whether two discs were too near among a goal's robots and obstacles."""
    if view.map.is_wrong == 0 and is_quiet(view, g):
        return False
    if len(view.calm) > 0:
        rouse(view, g)
        if view.quiet[g] > view.mission.tick:
            return False
    gap = view.gaps[g]
    if gap.limit >= 0.0 and view.goals[g].n_members > FEW:
        gap.least = gap_between_neighbours(view, g, gap_to_obstacles(view, g, gap.limit))
        gap.tick = view.mission.tick
        return gap.least < 0.0
    return hits_obstacle(view, g) or hits_robot(view, g)


@kernel
def is_calm(view: State, m: int) -> bool:
    """Return whether surely nothing is near a member, nor foreseen to come near."""
    return len(view.calm) > 0 and view.calm[m] > view.mission.tick


@kernel
def rouse(view: State, g: int) -> None:
    """Decide which of up to ``FEW`` members are calm in this tick, and until when all are.

    A member is looked at when its time is over, or when its position jumps.
    """
    goal, tick = view.goals[g], view.mission.tick
    if goal.n_members > FEW:
        return
    may_jump = view.map.displaced >= tick
    for m in range(goal.first_member, goal.first_member + goal.n_members):
        index = view.members[m].robot
        robot = view.robots[index]
        has_jumped = may_jump and jumps(view.wakes[index], robot.x, robot.y)
        if has_jumped or abs(view.calm[m]) <= tick:
            look(view, goal, m)
    if view.map.is_wrong == 1:
        for h in range(goal.first_hazard, goal.first_hazard + goal.n_hazards):
            if is_displaced(view, view.hazards[h]):
                rouse_near(view, goal, view.hazards[h])
    until = NEVER
    for m in range(goal.first_member, goal.first_member + goal.n_members):
        until = min(until, view.calm[m])
    view.quiet[g] = until


@kernel
def rouse_near(view: State, goal: GoalState, hazard: int) -> None:
    """Wake the members near an obstacle that is not where the map has it."""
    obstacle = view.obstacles[hazard]
    for m in range(goal.first_member, goal.first_member + goal.n_members):
        robot = view.robots[view.members[m].robot]
        dx, dy = obstacle.x - robot.x, obstacle.y - robot.y
        reach = view.scopes[m].reach + obstacle.radius
        if dx * dx + dy * dy < reach * reach:
            view.calm[m] = min(view.calm[m], view.mission.tick)


@kernel
def look(view: State, goal: GoalState, m: int) -> None:
    """Calm a member until something can be near it, and other members no longer than that.

    One that would be calm for less than ``CALM`` ticks stays awake for some, without a look.
    """
    tick, own, robot = view.mission.tick, view.scopes[m], view.robots[view.members[m].robot]
    far = min(own.reach + LONGEST * own.step, view.map.reach)
    least = tick + untouched(far, 0.0, own.reach, own.step)
    cell = cell_at(view, robot.x, robot.y)
    for k in range(view.cells[cell], view.cells[cell + 1]):
        mapped = view.mapped[k]
        if mapped.gap >= far:
            break
        obstacle = view.obstacles[mapped.obstacle]
        dx, dy = obstacle.model_x - robot.x, obstacle.model_y - robot.y
        least = min(least, tick + untouched(dx, dy, own.reach + obstacle.radius, own.step))
    for n in range(goal.first_member, goal.first_member + goal.n_members):
        if n != m:
            other, second = view.scopes[n], view.robots[view.members[n].robot]
            dx, dy, reach = second.x - robot.x, second.y - robot.y, own.reach + other.reach
            due = tick + untouched(dx, dy, reach, own.step + other.step)
            view.calm[n] = min(view.calm[n], due)
            least = min(least, due)
    view.calm[m] = least if least >= tick + CALM else -(tick + AWAKE)


@kernel
def untouched(dx: float, dy: float, reach: float, step: float) -> int:
    """Return for how many ticks, at most ``LONGEST``, a distance is surely not below ``reach``.

    ``step`` is the most that it falls in a tick.
    """
    square, far = dx * dx + dy * dy, reach + LONGEST * step
    if square >= far * far:
        return LONGEST
    if square < reach * reach:
        return 0
    return min(patience(math.sqrt(square), reach, step), LONGEST)


@kernel
def brush(view: State, g: int) -> float:
    """Return how far from where a robot is an obstacle's edge is at most, if it was too near."""
    return 0.5 * (view.apart[g] + view.goals[g].distance) + view.longest[g]


@kernel
def hits_obstacle(view: State, g: int) -> bool:
    """Return whether a disc of a goal's robots was too near to one of its obstacles."""
    goal = view.goals[g]
    reach = brush(view, g)
    is_mapped = reach <= view.map.reach
    for m in range(goal.first_member, goal.first_member + goal.n_members):
        if is_calm(view, m):
            continue
        index = view.members[m].robot
        robot = view.robots[index]
        cell = cell_at(view, robot.x, robot.y)
        for k in range(view.cells[cell], view.cells[cell + 1]):
            mapped = view.mapped[k]
            if mapped.gap >= reach:
                break
            hazard = mapped.obstacle
            if hits(view, goal, index, hazard, reach) and is_listed(view, goal, hazard):
                return True
    if view.map.is_wrong or not is_mapped:
        return hits_unmapped(view, g, reach, is_mapped)
    return False


@kernel
def hits_unmapped(view: State, g: int, reach: float, is_mapped: bool) -> bool:
    """Return whether a robot was too near to an obstacle that is not where the map has it.

    If the map does not reach as far as a robot can have moved, all obstacles are checked.
    """
    goal = view.goals[g]
    for h in range(goal.first_hazard, goal.first_hazard + goal.n_hazards):
        hazard = view.hazards[h]
        if not is_mapped or is_displaced(view, hazard):
            for m in range(goal.first_member, goal.first_member + goal.n_members):
                if hits(view, goal, view.members[m].robot, hazard, reach):
                    return True
    return False


@kernel
def hits(view: State, goal: GoalState, index: int, hazard: int, reach: float) -> bool:
    """Return whether a robot was too near to an obstacle, from whose edge it has to be in reach."""
    robot, obstacle = view.robots[index], view.obstacles[hazard]
    dx, dy, near = obstacle.x - robot.x, obstacle.y - robot.y, (reach + obstacle.radius) * SURE
    is_near = dx * dx + dy * dy < near * near
    return is_near and gap_to(view, goal, index, hazard, 0.0) < 0.0


@kernel
def gap_to(view: State, goal: GoalState, index: int, hazard: int, limit: float) -> float:
    """Return the gap between a robot and an obstacle, or ``limit`` if that is less."""
    robot, obstacle, wake = view.robots[index], view.obstacles[hazard], view.wakes[index]
    dx, dy = obstacle.x - robot.x, obstacle.y - robot.y
    was_x, was_y = obstacle.x - wake.x, obstacle.y - wake.y
    both = view.traits[index].radius + obstacle.radius + goal.distance
    if is_beyond(dx, dy, was_x, was_y, limit + both):
        return limit
    has_jumped = jumps(wake, robot.x, robot.y)
    if has_jumped or jumps(view.wakes[len(view.robots) + hazard], obstacle.x, obstacle.y):
        was_x, was_y = dx, dy
    shape = view.outlines[hazard]
    if shape.n_corners == 0:
        return gap_on_way(dx, dy, was_x, was_y, both, limit)
    first, n = shape.first_corner, shape.n_corners
    off = off_way(view.corners, first, n, -dx, -dy, dx - was_x, dy - was_y)
    return min(excess(obstacle.radius + off, both), limit)


@kernel
def is_beyond(dx: float, dy: float, was_x: float, was_y: float, reach: float) -> bool:
    """Return quickly whether a way surely keeps farther than ``reach`` from the origin."""
    near = (reach + abs(was_x - dx) + abs(was_y - dy)) * SURE
    return dx * dx + dy * dy >= near * near


@kernel
def gap_on_way(
    dx: float, dy: float, was_x: float, was_y: float, both: float, limit: float
) -> float:
    """Return the least distance of two centres minus both radii, or ``limit`` if that is less.

    One centre moves as seen from the other, from ``was_x, was_y`` to ``dx, dy``.
    """
    square = square_off(-dx, -dy, was_x - dx, was_y - dy)
    near = (limit + both) * SURE
    if square >= near * near:
        return limit
    return min(excess(math.sqrt(square), both), limit)


@kernel
def hits_robot(view: State, g: int) -> bool:
    """Return whether two discs of a goal's robots were too near to each other."""
    goal = view.goals[g]
    last = goal.first_member + goal.n_members
    if goal.n_members > FEW:
        return gap_between_neighbours(view, g, 0.0) < 0.0
    near = (view.apart[g] + 2.0 * view.longest[g]) * SURE
    for m in range(goal.first_member, last):
        if is_calm(view, m):
            continue
        index = view.members[m].robot
        robot = view.robots[index]
        x, y = robot.x, robot.y
        for n in range(m + 1, last):
            other = view.members[n].robot
            dx, dy = view.robots[other].x - x, view.robots[other].y - y
            if dx * dx + dy * dy < near * near and gap_between(view, goal, index, other, 0.0) < 0.0:
                return True
    return False


@kernel
def gap_between(view: State, goal: GoalState, index: int, other: int, limit: float) -> float:
    """Return the gap between two robots, or ``limit`` if that is less."""
    robot, second = view.robots[index], view.robots[other]
    wake, trail = view.wakes[index], view.wakes[other]
    dx, dy = second.x - robot.x, second.y - robot.y
    was_x, was_y = trail.x - wake.x, trail.y - wake.y
    both = view.traits[index].radius + view.traits[other].radius + goal.distance
    if is_beyond(dx, dy, was_x, was_y, limit + both):
        return limit
    if jumps(wake, robot.x, robot.y) or jumps(trail, second.x, second.y):
        was_x, was_y = dx, dy
    return gap_on_way(dx, dy, was_x, was_y, both, limit)


@kernel
def margin(world: State, g: int, least: float) -> tuple[float, int]:
    """Return the least gap between two discs, and when one can be below ``least``.

    The default check of more than ``FEW`` members has found it in this tick.
    """
    speed, spare, gap = world.longest[g], max(least, 0.0), world.gaps[g]
    ahead = HORIZON if world.goals[g].n_members <= FEW else 0
    to_obstacle = to_robot = gap.least
    if gap.tick != world.mission.tick:
        to_obstacle = gap_to_obstacles(world, g, spare + ahead * speed)
        to_robot = gap_between_robots(world, g, spare + 2.0 * ahead * speed)
    left = min(to_obstacle, to_robot)
    if left <= least:
        return left, 1
    return left, min(patience(to_obstacle, least, speed), patience(to_robot, least, 2.0 * speed))


@kernel
def gap_to_obstacles(world: State, g: int, limit: float) -> float:
    """Return the least gap between robots and obstacles, at their model positions, or ``limit``."""
    goal, reach, least = world.goals[g], brush(world, g), limit
    for m in range(goal.first_member, goal.first_member + goal.n_members):
        index = world.members[m].robot
        robot = world.robots[index]
        cell = cell_at(world, robot.x, robot.y)
        for k in range(world.cells[cell], world.cells[cell + 1]):
            mapped = world.mapped[k]
            if mapped.gap - reach >= least:
                break
            gap = gap_to(world, goal, index, mapped.obstacle, least)
            if gap < least and is_listed(world, goal, mapped.obstacle):
                least = gap
        if least > world.map.reach - reach:  # no cell lists obstacles beyond
            for h in range(goal.first_hazard, goal.first_hazard + goal.n_hazards):
                least = gap_to(world, goal, index, world.hazards[h], least)
    return least


@kernel
def gap_between_robots(world: State, g: int, limit: float) -> float:
    """Return the least gap between two robots, or ``limit``."""
    goal, least = world.goals[g], limit
    last = goal.first_member + goal.n_members
    if goal.n_members > FEW:
        return gap_between_neighbours(world, g, limit)
    for m in range(goal.first_member, last):
        for n in range(m + 1, last):
            index, other = world.members[m].robot, world.members[n].robot
            least = gap_between(world, goal, index, other, least)
    return least


@kernel
def gap_between_neighbours(view: State, g: int, limit: float) -> float:
    """Return the least gap between two of more than ``FEW`` robots, at most ``limit``.

    No two robots beyond ``apart`` have a gap below 0 where they are.
    """
    goal, least = view.goals[g], limit
    apart = view.apart[g] + 2.0 * view.longest[g]
    chart(view, goal, apart + view.longest[g])  # for most margins, too
    for m in range(goal.first_member, goal.first_member + goal.n_members):
        index = view.members[m].robot
        for k in range(gather(view, goal, index, apart + least)):
            least = gap_between(view, goal, index, view.lookup.nearby[k], least)
    return least


@kernel
def react(ci: State, g: int) -> None:
    """Turn every member whose gap will soon be below its radius to the heading with the widest.

    One that evaded in the tick before is also judged by the heading that a later goal was denied
    then, as that goal would lead it back.
    """
    if not needs_reaction(ci, g):
        return
    goal = ci.goals[g]
    farthest = foreseen(ci, goal)
    chart(ci, goal, 0.5 * ci.apart[g] + 2.0 * farthest + ci.apart[g])
    for m in range(goal.first_member, goal.first_member + goal.n_members):
        if is_calm(ci, m):
            continue
        index = ci.members[m].robot
        command, wish = ci.commands[index], ci.wishes[index]
        least = ci.traits[index].radius
        n_near = gather(ci, goal, index, sight(ci, g, index, least, farthest))
        gap = gap_along(ci, goal, index, n_near, command.heading_x, command.heading_y, least)
        if wish.tick + 1 == ci.mission.tick and (wish.x != 0.0 or wish.y != 0.0):
            gap = min(gap, gap_along(ci, goal, index, n_near, wish.x, wish.y, least))
        if excess(gap, least) < 0.0:
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
    edge = leeway(ci, index)
    best = -1
    most = 0.0
    for degrees in range(0, len(ci.directions), CANDIDATE_STEP):
        heading = ci.directions[degrees]
        mission = ci.mission
        x, y = robot.x + reach * heading.x, robot.y + reach * heading.y
        if well_inside(x, y, mission.x, mission.y, mission.radius, edge):
            gap = gap_along(ci, goal, index, n_near, heading.x, heading.y, limit)
            if best < 0 or gap > most + TOLERANCE:
                best = degrees
                most = gap
    if best >= 0 and ci.commands[index].heading_claimed == 0:
        wish = ci.wishes[index]
        wish.tick, wish.x, wish.y = ci.mission.tick, 0.0, 0.0
        steer(ci, index, ci.directions[best].x, ci.directions[best].y)


@kernel
def sight(ci: State, g: int, index: int, limit: float, farthest: float) -> float:
    """Return the distance beyond which another robot's gap cannot fall below ``limit``.

    ``farthest`` is the most that any other robot moves within the look-ahead, with its berth.
    """
    return limit + LOOK_AHEAD * pace(ci, index) + berth(ci, index) + farthest + ci.apart[g]


@kernel
def foreseen(ci: State, goal: GoalState) -> float:
    """Return the most that a member moves within the look-ahead, with its berth."""
    most = 0.0
    for m in range(goal.first_member, goal.first_member + goal.n_members):
        index = ci.members[m].robot
        most = max(most, LOOK_AHEAD * pace(ci, index) + berth(ci, index))
    return most


@kernel
def room(ci: State, goal: GoalState, index: int) -> float:
    """Return the radius of a robot plus the clearance and its berth: what reactions keep."""
    return ci.traits[index].radius + goal.distance + berth(ci, index)


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
    own = room(ci, goal, index)
    ahead = LOOK_AHEAD * step
    least = gap_to_obstacles_along(ci, goal, index, own, ahead, step * x, step * y, limit)
    for k in range(n_near):
        other = ci.lookup.nearby[k]
        dx, dy = ci.robots[other].x - robot.x, ci.robots[other].y - robot.y
        other_step = pace(ci, other)
        both = own + (ci.traits[other].radius + berth(ci, other))
        near = least + LOOK_AHEAD * (step + other_step) + both
        if abs(dx) < near and abs(dy) < near:
            command = ci.commands[other]
            vx = other_step * command.heading_x - step * x
            vy = other_step * command.heading_y - step * y
            least = min(least, closest(dx, dy, vx, vy) - both)
    return least


@kernel
def gap_to_obstacles_along(
    ci: State,
    goal: GoalState,
    index: int,
    own: float,
    ahead: float,
    vx: float,
    vy: float,
    limit: float,
) -> float:
    """Return the least gap to a goal's obstacles, for a given velocity; as ``gap_along``.

    ``own`` is the robot's ``room``, ``ahead`` how far it moves within the look-ahead. If the map
    does not reach as far as that, all obstacles are checked.
    """
    robot = ci.robots[index]
    reach = limit + ahead + own
    is_mapped = reach <= ci.map.reach
    least = limit
    if is_mapped:
        cell = cell_at(ci, robot.x, robot.y)
        for k in range(ci.cells[cell], ci.cells[cell + 1]):
            mapped = ci.mapped[k]
            if mapped.gap >= reach:
                break
            gap = gap_to_obstacle(ci, index, own, mapped.obstacle, vx, vy, reach - limit + least)
            if gap < least and is_listed(ci, goal, mapped.obstacle):
                least = gap
        if ci.map.is_wrong == 0:
            return least
    for h in range(goal.first_hazard, goal.first_hazard + goal.n_hazards):
        if not is_mapped or is_displaced(ci, ci.hazards[h]):
            near = reach - limit + least
            least = min(least, gap_to_obstacle(ci, index, own, ci.hazards[h], vx, vy, near))
    return least


@kernel
def gap_to_obstacle(
    ci: State, index: int, own: float, hazard: int, vx: float, vy: float, reach: float
) -> float:
    """Return the gap to an obstacle within the look-ahead, or ``reach`` if it is too far away.

    ``own`` is the robot's ``room``, ``vx`` and ``vy`` its motion in a tick. A gap counts only
    within ``reach`` of the obstacle's edge.
    """
    robot = ci.robots[index]
    obstacle = ci.obstacles[hazard]
    dx, dy = obstacle.x - robot.x, obstacle.y - robot.y
    near = reach + obstacle.radius
    if abs(dx) >= near or abs(dy) >= near:
        return reach
    shape = ci.outlines[hazard]
    if shape.n_corners > 0:
        off = off_segment(dx, dy, LOOK_AHEAD * vx, LOOK_AHEAD * vy)
        if off >= near - LOOK_AHEAD * pace(ci, index):
            return reach
        return closest_to_polygon(ci, shape, -dx, -dy, vx, vy) - own
    return closest(dx, dy, -vx, -vy) - obstacle.radius - own


@kernel
def closest(dx: float, dy: float, vx: float, vy: float) -> float:
    """Return the least distance of a moving point from the origin until ``LOOK_AHEAD`` ticks later.

    A point that moves away counts from the next tick on: where it is now cannot be mended.
    """
    square = vx * vx + vy * vy
    when = 0.0
    if square > 0.0:
        when = -(dx * vx + dy * vy) / square
    when = min(when, float(LOOK_AHEAD)) if when > 0.0 else 1.0
    x, y = dx + when * vx, dy + when * vy
    return math.sqrt(x * x + y * y)


@kernel
def closest_to_polygon(
    ci: State, shape: AreaState, x: float, y: float, vx: float, vy: float
) -> float:
    """Return the least distance of a moving point from a polygon; otherwise as ``closest``."""
    first, n, last = shape.first_corner, shape.n_corners, float(LOOK_AHEAD)
    least = off_way(ci.corners, first, n, x, y, last * vx, last * vy)
    if least < off_polygon(ci.corners, first, n, x, y):
        return least
    rest = last - 1.0
    return off_way(ci.corners, first, n, x + vx, y + vy, rest * vx, rest * vy)
