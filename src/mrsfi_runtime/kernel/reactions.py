"""What the reference collective intelligence does about its goals, one reaction per task.

A team replaces these region by region in the generated ``collective_intelligence.py``.

References
----------
Source paper, section III-G. The paper leaves the logic to the user; what stands here is
described in ``docs/semantics.md``.
"""

import math

from mrsfi_runtime.kernel.commands import set_speed, steer, switch_sensor
from mrsfi_runtime.kernel.compiling import kernel
from mrsfi_runtime.kernel.directions import N_DIRECTIONS
from mrsfi_runtime.kernel.neighbours import chart, gather
from mrsfi_runtime.kernel.obstacles import cell_at, is_displaced, is_listed
from mrsfi_runtime.kernel.randomness import PURPOSE_ROAM, choice
from mrsfi_runtime.kernel.state import GoalState, State
from mrsfi_runtime.kernel.tasks import ROBOT_RADIUS, distance, inside, sensor_power, ticks_left

LOOK_AHEAD = 10
"""Ticks for which a collision is foreseen."""

MARGIN = 1.0
"""Clearance below which a meeting counts as a coming collision, in distance units."""

CANDIDATE_STEP = 15
"""Degrees between the headings among which a robot chooses when it evades."""

ROAM_ATTEMPTS = 8


@kernel
def pace(ci: State, index: int) -> float:
    """Return the distance that a robot may move in a tick, as far as is known."""
    return max(ci.commands[index].speed, ci.robots[index].nominal_speed)


@kernel
def avoid_collision(ci: State, g: int) -> None:
    """Turn every member that will soon collide to the heading with the most clearance."""
    goal = ci.goals[g]
    farthest = 0.0
    for m in range(goal.first_member, goal.first_member + goal.n_members):
        farthest = max(farthest, LOOK_AHEAD * pace(ci, ci.members[m].robot))
    chart(ci, goal, 2.0 * (MARGIN + 2.0 * farthest + 2.0 * ROBOT_RADIUS))
    for m in range(goal.first_member, goal.first_member + goal.n_members):
        index = ci.members[m].robot
        command = ci.commands[index]
        n_near = gather(ci, goal, index, sight(ci, index, MARGIN, farthest))
        x = command.heading_x
        y = command.heading_y
        if clearance(ci, goal, index, n_near, x, y, MARGIN) < MARGIN:
            evade(ci, goal, index, farthest)


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
def evade(ci: State, goal: GoalState, index: int, farthest: float) -> None:
    """Steer a robot to the heading with the most clearance that keeps it in the mission area."""
    robot = ci.robots[index]
    reach = LOOK_AHEAD * pace(ci, index)
    limit = 2.0 * reach
    n_near = gather(ci, goal, index, sight(ci, index, limit, farthest))
    best = -1
    most = 0.0
    for degrees in range(0, N_DIRECTIONS, CANDIDATE_STEP):
        heading = ci.directions[degrees]
        mission = ci.mission
        x = robot.x + reach * heading.x
        y = robot.y + reach * heading.y
        out = distance(x, y, mission.x, mission.y)
        if out <= mission.radius:
            clear = clearance(ci, goal, index, n_near, heading.x, heading.y, limit)
            if best < 0 or clear > most:
                best = degrees
                most = clear
    if best >= 0:
        steer(ci, index, ci.directions[best].x, ci.directions[best].y)


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
        Number of robots in ``ci.nearby`` that may come nearer than ``limit``.
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
        other = ci.nearby[k]
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


@kernel
def stay_within_mission_area(ci: State, g: int) -> None:
    """Turn every member that is outside the mission area, or about to leave it, to its centre."""
    goal = ci.goals[g]
    mission = ci.mission
    for m in range(goal.first_member, goal.first_member + goal.n_members):
        index = ci.members[m].robot
        robot = ci.robots[index]
        command = ci.commands[index]
        step = 2.0 * pace(ci, index)
        x = robot.x + step * command.heading_x
        y = robot.y + step * command.heading_y
        if distance(x, y, mission.x, mission.y) > mission.radius:
            steer(ci, index, mission.x - robot.x, mission.y - robot.y)


@kernel
def sufficient_energy(ci: State, g: int) -> None:
    """Regulate every member's speed to its nominal one, or to what its energy affords.

    The loop is closed over the reported speed (command + wanted − believed), so that a false
    report moves a real robot.
    """
    goal = ci.goals[g]
    left = ticks_left(ci)
    for m in range(goal.first_member, goal.first_member + goal.n_members):
        index = ci.members[m].robot
        robot = ci.robots[index]
        wanted = robot.nominal_speed
        if left > 0 and robot.energy_per_distance > 0.0:
            spare = robot.energy / left - sensor_power(ci, index)
            wanted = min(wanted, max(spare / robot.energy_per_distance, 0.0))
        set_speed(ci, index, ci.commands[index].speed + wanted - robot.speed)


@kernel
def gather_samples(ci: State, g: int) -> None:
    """Keep the goal's robot roaming inside its area, its sensor on until the target is reached."""
    goal = ci.goals[g]
    sensor = ci.sensors[goal.sensor]
    switch_sensor(ci, goal.sensor, 1 if goal.count < goal.target else 0)
    roam(ci, goal, sensor.robot)


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
        degrees = choice(N_DIRECTIONS, mission.seed, mission.tick, entity, PURPOSE_ROAM)
        turn = ci.directions[degrees]
        if inside(robot.x + 2.0 * step * turn.x, robot.y + 2.0 * step * turn.y, goal):
            steer(ci, index, turn.x, turn.y)
            return
    steer(ci, index, goal.x - robot.x, goal.y - robot.y)


@kernel
def patrol(ci: State, g: int) -> None:
    """Head for the area from outside, roam inside it."""
    goal = ci.goals[g]
    for m in range(goal.first_member, goal.first_member + goal.n_members):
        roam(ci, goal, ci.members[m].robot)


@kernel
def stay(ci: State, g: int) -> None:
    """Head for the area from outside, roam inside it."""
    patrol(ci, g)


@kernel
def visit(ci: State, g: int) -> None:
    """Head for the point until it has been reached, the last step no longer than needed."""
    goal = ci.goals[g]
    for m in range(goal.first_member, goal.first_member + goal.n_members):
        member = ci.members[m]
        if member.reached == 0:
            approach(ci, member.robot, goal.x, goal.y)
        else:
            set_speed(ci, member.robot, ci.robots[member.robot].nominal_speed)


@kernel
def track(ci: State, g: int) -> None:
    """Head for every member's next waypoint, the last step no longer than needed."""
    goal = ci.goals[g]
    for m in range(goal.first_member, goal.first_member + goal.n_members):
        member = ci.members[m]
        if member.waypoint < goal.n_waypoints:
            point = ci.waypoints[goal.first_waypoint + member.waypoint]
            approach(ci, member.robot, point.x, point.y)
        else:
            set_speed(ci, member.robot, ci.robots[member.robot].nominal_speed)


@kernel
def approach(ci: State, index: int, x: float, y: float) -> None:
    """Head for a point at nominal speed, slower only for the last step."""
    robot = ci.robots[index]
    steer(ci, index, x - robot.x, y - robot.y)
    set_speed(ci, index, min(robot.nominal_speed, distance(robot.x, robot.y, x, y)))


@kernel
def fixed_distance_between_robots(ci: State, g: int) -> None:
    """Let every later member close or open the gap to the one before it, else fly beside it."""
    goal = ci.goals[g]
    for m in range(goal.first_member + 1, goal.first_member + goal.n_members):
        first = ci.members[m - 1].robot
        index = ci.members[m].robot
        leader = ci.robots[first]
        robot = ci.robots[index]
        dx = leader.x - robot.x
        dy = leader.y - robot.y
        gap = math.sqrt(dx * dx + dy * dy)
        if gap - goal.distance > 0.5 * goal.tolerance:
            steer(ci, index, dx, dy)
        elif goal.distance - gap > 0.5 * goal.tolerance:
            steer(ci, index, -dx, -dy)
        else:
            steer(ci, index, ci.commands[first].heading_x, ci.commands[first].heading_y)
