"""When a goal is violated: progress and one predicate for each of the nine goal tasks.

Every predicate reads one ``State``: the collective intelligence's local state for believed
violations, the simulation's for true ones.

References
----------
Source paper, sections III-B a) and III-G (``checkRequirements``).
"""

import math

from mrsfi_runtime.kernel.compiling import kernel
from mrsfi_runtime.kernel.neighbours import FEW, chart, gather
from mrsfi_runtime.kernel.obstacles import cell_at, is_displaced, is_listed
from mrsfi_runtime.kernel.state import GoalState, State

ROBOT_RADIUS = 1.0

CELL = 32.0
"""Side of the cells in which overlapping robots are looked for, in distance units."""

AVOID_COLLISION, STAY_WITHIN, SUFFICIENT_ENERGY, GATHER_SAMPLES = 0, 1, 2, 3
PATROL, VISIT, TRACK, STAY, FIXED_DISTANCE = 4, 5, 6, 7, 8


@kernel
def progress(view: State) -> None:
    """Bring the progress of every goal up to the tick of a state, before goals are checked."""
    for goal in view.goals:
        if goal.task == GATHER_SAMPLES:
            count_samples(view, goal)
        elif goal.task in (PATROL, STAY, VISIT):
            enter(view, goal)
        elif goal.task == TRACK:
            follow(view, goal)


@kernel
def count_samples(view: State, goal: GoalState) -> None:
    """Count new samples: taken inside the area, and not where the sample before was taken."""
    sensor = view.sensors[goal.sensor]
    robot = view.robots[sensor.robot]
    new = sensor.count - goal.seen
    goal.seen = sensor.count
    if new <= 0 or not inside(robot.x, robot.y, goal):
        return
    if goal.count == 0 or robot.x != goal.sampled_x or robot.y != goal.sampled_y:
        goal.count += new
        goal.sampled_x = robot.x
        goal.sampled_y = robot.y


@kernel
def enter(view: State, goal: GoalState) -> None:
    """Note which members are inside the goal's area, or within tolerance of its point."""
    for m in range(goal.first_member, goal.first_member + goal.n_members):
        member = view.members[m]
        robot = view.robots[member.robot]
        reach = goal.radius + goal.tolerance
        if distance(robot.x, robot.y, goal.x, goal.y) <= reach:
            member.since = view.mission.tick
            member.reached = 1


@kernel
def follow(view: State, goal: GoalState) -> None:
    """Advance every member's next waypoint past those it is within tolerance of."""
    for m in range(goal.first_member, goal.first_member + goal.n_members):
        member = view.members[m]
        robot = view.robots[member.robot]
        while member.waypoint < goal.n_waypoints:
            point = view.waypoints[goal.first_waypoint + member.waypoint]
            if distance(robot.x, robot.y, point.x, point.y) > goal.tolerance:
                break
            member.waypoint += 1


@kernel
def distance(x: float, y: float, to_x: float, to_y: float) -> float:
    """Return the distance of two points in the plane."""
    dx = to_x - x
    dy = to_y - y
    return math.sqrt(dx * dx + dy * dy)


@kernel
def inside(x: float, y: float, goal: GoalState) -> bool:
    """Return whether a point is inside a goal's area."""
    dx = x - goal.x
    dy = y - goal.y
    return dx * dx + dy * dy <= goal.radius * goal.radius


@kernel
def ticks_left(view: State) -> int:
    """Return how many ticks follow the present one."""
    return view.mission.duration - 1 - view.mission.tick


@kernel
def avoid_collision_violated(view: State, g: int) -> bool:
    """Return whether two discs overlap among a goal's robots and obstacles.

    Parameters
    ----------
    view
        Local state or true state.
    g
        Index of the goal.
    """
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
    """Return whether a disc overlaps with an obstacle that is not where the model puts it."""
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
        x = robot.x
        y = robot.y
        for other in range(m + 1, last):
            second = view.robots[view.members[other].robot]
            if overlap(second.x - x, second.y - y, both):
                return True
    return False


@kernel
def hits_neighbour(view: State, goal: GoalState, both: float) -> bool:
    """Return whether two of many robots are nearer to each other than a distance."""
    chart(view, goal, CELL)
    for m in range(goal.first_member, goal.first_member + goal.n_members):
        index = view.members[m].robot
        robot = view.robots[index]
        for k in range(gather(view, goal, index, both)):
            other = view.robots[view.nearby[k]]
            if overlap(other.x - robot.x, other.y - robot.y, both):
                return True
    return False


@kernel
def overlap(dx: float, dy: float, reach: float) -> bool:
    """Return whether two discs overlap whose radii add up to ``reach``."""
    return dx * dx + dy * dy < reach * reach


@kernel
def stay_within_mission_area_violated(view: State, g: int) -> bool:
    """Return whether a member is farther from the mission's centre than its radius."""
    goal = view.goals[g]
    mission = view.mission
    for m in range(goal.first_member, goal.first_member + goal.n_members):
        robot = view.robots[view.members[m].robot]
        dx = robot.x - mission.x
        dy = robot.y - mission.y
        if dx * dx + dy * dy > mission.radius * mission.radius:
            return True
    return False


@kernel
def sensor_power(view: State, index: int) -> float:
    """Return the energy that a robot's active sensors spend in a tick, as far as is known."""
    robot = view.robots[index]
    power = 0.0
    for k in range(robot.first_sensor, robot.first_sensor + robot.n_sensors):
        sensor = view.sensors[k]
        if sensor.active == 1:
            power += sensor.rate * sensor.cost
    return power


@kernel
def energy_reserve(view: State, index: int) -> float:
    """Return the energy that a robot has beyond its forecast need; negative if it lacks some.

    The forecast takes its speed, sensor rates and costs as known now for all ticks left.
    """
    robot = view.robots[index]
    power = robot.speed * robot.energy_per_distance + sensor_power(view, index)
    return robot.energy - ticks_left(view) * power


@kernel
def sufficient_energy_violated(view: State, g: int) -> bool:
    """Return whether a member is exhausted, or its energy below the forecast need."""
    goal = view.goals[g]
    for m in range(goal.first_member, goal.first_member + goal.n_members):
        index = view.members[m].robot
        if view.robots[index].energy <= 0.0 or energy_reserve(view, index) < 0.0:
            return True
    return False


@kernel
def sample_reserve(view: State, goal: GoalState) -> float:
    """Return the samples that a goal's forecast has beyond its target; negative if it lacks some.

    The forecast is one valid sample a tick, scaled by believed over nominal rate.
    """
    sensor = view.sensors[goal.sensor]
    return goal.count + ticks_left(view) * (sensor.rate / sensor.nominal_rate) - goal.target


@kernel
def gather_samples_violated(view: State, g: int) -> bool:
    """Return whether a goal below its target is in danger of missing it.

    It is while its sensor is inactive, or its robot outside the goal's area, or when the
    forecast falls short.
    """
    goal = view.goals[g]
    if goal.count >= goal.target:
        return False
    sensor = view.sensors[goal.sensor]
    robot = view.robots[sensor.robot]
    if sensor.active == 0 or not inside(robot.x, robot.y, goal):
        return True
    return sample_reserve(view, goal) < 0.0


@kernel
def patrol_violated(view: State, g: int) -> bool:
    """Return whether a member has not been inside the area for one period."""
    goal = view.goals[g]
    for m in range(goal.first_member, goal.first_member + goal.n_members):
        if view.mission.tick - view.members[m].since >= goal.period:
            return True
    return False


@kernel
def visit_violated(view: State, g: int) -> bool:
    """Return whether a member has not been at the point by the deadline."""
    goal = view.goals[g]
    if view.mission.tick < goal.deadline:
        return False
    for m in range(goal.first_member, goal.first_member + goal.n_members):
        if view.members[m].reached == 0:
            return True
    return False


@kernel
def track_violated(view: State, g: int) -> bool:
    """Return whether a member is off its current segment by more than the tolerance.

    Before the first waypoint and after the last there is no current segment.
    """
    goal = view.goals[g]
    for m in range(goal.first_member, goal.first_member + goal.n_members):
        member = view.members[m]
        if 0 < member.waypoint < goal.n_waypoints:
            robot = view.robots[member.robot]
            start = view.waypoints[goal.first_waypoint + member.waypoint - 1]
            end = view.waypoints[goal.first_waypoint + member.waypoint]
            off = off_segment(
                robot.x - start.x, robot.y - start.y, end.x - start.x, end.y - start.y
            )
            if off > goal.tolerance:
                return True
    return False


@kernel
def off_segment(x: float, y: float, end_x: float, end_y: float) -> float:
    """Return the distance of a point from the segment between the origin and an end."""
    length = end_x * end_x + end_y * end_y
    share = 0.0
    if length > 0.0:
        share = min(max((x * end_x + y * end_y) / length, 0.0), 1.0)
    return distance(x, y, share * end_x, share * end_y)


@kernel
def stay_violated(view: State, g: int) -> bool:
    """Return whether a member has left the area after it first entered."""
    goal = view.goals[g]
    for m in range(goal.first_member, goal.first_member + goal.n_members):
        member = view.members[m]
        if member.reached == 1 and member.since != view.mission.tick:
            return True
    return False


@kernel
def fixed_distance_between_robots_violated(view: State, g: int) -> bool:
    """Return whether a pair of members differs from the distance by more than the tolerance."""
    goal = view.goals[g]
    last = goal.first_member + goal.n_members
    for m in range(goal.first_member, last):
        robot = view.robots[view.members[m].robot]
        for other in range(m + 1, last):
            second = view.robots[view.members[other].robot]
            gap = distance(robot.x, robot.y, second.x, second.y)
            if abs(gap - goal.distance) > goal.tolerance:
                return True
    return False
