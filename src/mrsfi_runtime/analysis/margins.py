"""How far a state is from violating a goal, in the quantities that the goal's check compares."""

import math
from collections.abc import Callable, Iterator
from itertools import combinations
from typing import TypeAlias

from mrsfi_runtime.kernel.forecast import energy_reserve, sample_reserve
from mrsfi_runtime.kernel.geometry import distance, off_segment
from mrsfi_runtime.kernel.goal_tasks import table
from mrsfi_runtime.kernel.state import GoalState, MemberState, RobotState, State
from mrsfi_runtime.kernel.tolerance import excess
from mrsfi_runtime.model.mission import ROBOT_RADIUS

DISTANCE, ENERGY, SAMPLES, TICKS = "distance units", "energy units", "samples", "ticks"
"""What is left to a limit, in words."""

Margins: TypeAlias = dict[str, float]
"""What is left to each limit of a goal; infinite if there is none now.

The reference check finds the goal violated exactly if one of them is negative.
"""


def margins(view: State, g: int) -> Margins | None:
    """Return what is left until a goal is violated.

    Parameters
    ----------
    view
        Local state or true state, after the goals' progress at its tick.
    g
        Index of the goal.

    Returns
    -------
    dict of float, or None
        ``None`` for a task of a team's own: nobody but its regions knows what it compares.
    """
    goal = view.goals[g]
    return None if goal.task == table.OWN_TASK else _MARGINS[goal.task](view, goal)


def _members(view: State, goal: GoalState) -> Iterator[tuple[MemberState, RobotState]]:
    for m in range(goal.first_member, goal.first_member + goal.n_members):
        yield view.members[m], view.robots[view.members[m].robot]


def _avoid_collision(view: State, goal: GoalState) -> Margins:
    robots = [robot for _, robot in _members(view, goal)]
    hazards = view.hazards[goal.first_hazard : goal.first_hazard + goal.n_hazards]
    obstacles = [view.obstacles[hazard] for hazard in hazards]
    gaps = [
        excess(distance(robot.x, robot.y, other.x, other.y), 2.0 * ROBOT_RADIUS)
        for robot, other in combinations(robots, 2)
    ]
    gaps += [
        excess(distance(robot.x, robot.y, other.x, other.y), other.radius + ROBOT_RADIUS)
        for robot in robots
        for other in obstacles
    ]
    return {DISTANCE: min(gaps, default=math.inf)}


def _stay_within_mission_area(view: State, goal: GoalState) -> Margins:
    area = view.mission
    inside = (
        -excess(distance(robot.x, robot.y, area.x, area.y), area.radius)
        for _, robot in _members(view, goal)
    )
    return {DISTANCE: min(inside, default=math.inf)}


def _sufficient_energy(view: State, goal: GoalState) -> Margins:
    spare = (
        energy_reserve(view, member.robot) if robot.energy > 0.0 else -math.inf
        for member, robot in _members(view, goal)
    )
    return {ENERGY: min(spare, default=math.inf)}


def _gather_samples(view: State, goal: GoalState) -> Margins:
    if goal.count >= goal.target:
        return {SAMPLES: math.inf, DISTANCE: math.inf}
    sensor = view.sensors[goal.sensor]
    robot = view.robots[sensor.robot]
    return {
        SAMPLES: sample_reserve(view, goal) if sensor.active else -math.inf,
        DISTANCE: -excess(distance(robot.x, robot.y, goal.x, goal.y), goal.radius),
    }


def _patrol(view: State, goal: GoalState) -> Margins:
    last = min((member.since for member, _ in _members(view, goal)), default=view.mission.tick)
    return {TICKS: goal.period - 1 - (view.mission.tick - last)}


def _visit(view: State, goal: GoalState) -> Margins:
    if all(member.reached for member, _ in _members(view, goal)):
        return {TICKS: math.inf}
    return {TICKS: goal.deadline - 1 - view.mission.tick}


def _track(view: State, goal: GoalState) -> Margins:
    within = math.inf
    for member, robot in _members(view, goal):
        if 0 < member.waypoint < goal.n_waypoints:
            start = view.waypoints[goal.first_waypoint + member.waypoint - 1]
            end = view.waypoints[goal.first_waypoint + member.waypoint]
            off = off_segment(
                robot.x - start.x, robot.y - start.y, end.x - start.x, end.y - start.y
            )
            within = min(within, -excess(off, goal.tolerance))
    return {DISTANCE: within}


def _stay(view: State, goal: GoalState) -> Margins:
    inside = (
        -excess(distance(robot.x, robot.y, goal.x, goal.y), goal.radius + goal.tolerance)
        for member, robot in _members(view, goal)
        if member.reached
    )
    return {DISTANCE: min(inside, default=math.inf)}


def _fixed_distance_between_robots(view: State, goal: GoalState) -> Margins:
    robots = [robot for _, robot in _members(view, goal)]
    within = (
        -excess(abs(distance(a.x, a.y, b.x, b.y) - goal.distance), goal.tolerance)
        for a, b in combinations(robots, 2)
    )
    return {DISTANCE: min(within, default=math.inf)}


_MARGINS: tuple[Callable[[State, GoalState], Margins], ...] = (
    _avoid_collision,
    _stay_within_mission_area,
    _sufficient_energy,
    _gather_samples,
    _patrol,
    _visit,
    _track,
    _stay,
    _fixed_distance_between_robots,
)
"""By the number of the task, as ``goal_tasks.table.TASKS``."""
