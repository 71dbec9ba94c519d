"""AvoidCollision: the discs of robots and obstacles never overlap."""

from dataclasses import dataclass

from mrsfi_runtime.kernel.commands import steer
from mrsfi_runtime.kernel.compiling import kernel
from mrsfi_runtime.kernel.directions import N_DIRECTIONS
from mrsfi_runtime.kernel.geometry import distance, overlap
from mrsfi_runtime.kernel.goal_tasks.clearance import LOOK_AHEAD, MARGIN, clearance, sight
from mrsfi_runtime.kernel.guidance import pace
from mrsfi_runtime.kernel.neighbours import FEW, chart, gather
from mrsfi_runtime.kernel.obstacles import cell_at, is_displaced, is_listed
from mrsfi_runtime.kernel.state import GoalState, State
from mrsfi_runtime.model.mission import ROBOT_RADIUS, Goal, GoalTask, Terms

CELL = 32.0
"""Side of the cells in which overlapping robots are looked for, in distance units."""

CANDIDATE_STEP = 15
"""Degrees between the headings among which a robot chooses when it evades."""


@dataclass(frozen=True, slots=True)
class AvoidCollision(GoalTask):
    """Keep robots (by ID) clear of each other and of obstacles (by ID)."""

    robots: tuple[str, ...]
    obstacles: tuple[str, ...] = ()

    def terms(self, goal: Goal) -> Terms:
        """Return the robots that the task names, and its obstacles."""
        del goal
        return Terms(self.robots, self.obstacles)


@kernel
def violated(view: State, g: int) -> bool:
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
            other = view.robots[view.lookup.nearby[k]]
            if overlap(other.x - robot.x, other.y - robot.y, both):
                return True
    return False


@kernel
def react(ci: State, g: int) -> None:
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
