"""Where in the mission things are: the goals' areas, and the window that shows them all."""

from collections.abc import Iterator
from dataclasses import dataclass

from mrsfi_runtime.model.mission import (
    Coordinates,
    GatherSamples,
    Goal,
    Mission,
    Patrol,
    Stay,
    Visit,
)


@dataclass(frozen=True, slots=True)
class GoalPlace:
    """A disc that a goal is about, in distance units."""

    goal: Goal
    x: float
    y: float
    radius: float


def goal_places(mission: Mission) -> tuple[GoalPlace, ...]:
    """Return the discs that the goals' tasks read, in model order.

    Goals whose area plays no part in their task have none.
    """
    return tuple(
        GoalPlace(goal, center.x, center.y, radius)
        for goal in mission.goals
        for center, radius in _discs(goal)
    )


def _discs(goal: Goal) -> Iterator[tuple[Coordinates, float]]:
    task = goal.task
    if isinstance(task, GatherSamples):
        if goal.area is not None:
            yield goal.area.center, goal.area.radius
    elif isinstance(task, Patrol | Stay):
        yield task.area.center, task.area.radius
    elif isinstance(task, Visit):
        yield task.coordinates, task.tolerance


def working_window(mission: Mission) -> tuple[float, float, float]:
    """Return the square around all robots' starts, obstacles and goal areas, with a margin.

    Returns
    -------
    tuple of float
        Centre x, centre y and half width, in distance units.
    """
    discs = [(place.x, place.y, place.radius) for place in goal_places(mission)]
    discs += [(robot.position.x, robot.position.y, 1.0) for robot in mission.robots]
    discs += [
        (obstacle.area.center.x, obstacle.area.center.y, obstacle.area.radius)
        for obstacle in mission.obstacles
    ]
    left, right = min(x - r for x, _, r in discs), max(x + r for x, _, r in discs)
    low, high = min(y - r for _, y, r in discs), max(y + r for _, y, r in discs)
    half = max(right - left, high - low) / 2
    return (left + right) / 2, (low + high) / 2, max(half * 1.12, mission.area.radius * 0.01)
