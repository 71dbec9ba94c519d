"""The discs that goals are about, and the window of a map that shows them all."""

from dataclasses import dataclass

from mrsfi_runtime.model.mission import ROBOT_RADIUS, Goal, Mission


@dataclass(frozen=True, slots=True)
class GoalDisc:
    """A disc that a goal is about, in distance units."""

    goal: Goal
    x: float
    y: float
    radius: float


def goal_discs(mission: Mission) -> tuple[GoalDisc, ...]:
    """Return the discs that the goals' tasks read, in model order.

    Goals whose area plays no part in their task have none.
    """
    return tuple(
        GoalDisc(goal, area.center.x, area.center.y, area.radius + goal.terms.tolerance)
        for goal in mission.goals
        if (area := goal.terms.area) is not None
    )


def working_window(mission: Mission) -> tuple[float, float, float]:
    """Return the square around all robots' starts, obstacles and goal areas, with a margin.

    Returns
    -------
    tuple of float
        Centre x, centre y and half width, in distance units.
    """
    discs = [(disc.x, disc.y, disc.radius) for disc in goal_discs(mission)]
    discs += [(robot.position.x, robot.position.y, ROBOT_RADIUS) for robot in mission.robots]
    discs += [
        (obstacle.area.center.x, obstacle.area.center.y, obstacle.area.radius)
        for obstacle in mission.obstacles
    ]
    left, right = min(x - r for x, _, r in discs), max(x + r for x, _, r in discs)
    low, high = min(y - r for _, y, r in discs), max(y + r for _, y, r in discs)
    half = max(right - left, high - low) / 2
    return (left + right) / 2, (low + high) / 2, max(half * 1.12, mission.area.radius * 0.01)
