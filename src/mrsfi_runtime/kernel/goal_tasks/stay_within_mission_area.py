"""StayWithinMissionArea: every member stays inside the mission area."""

import math
from dataclasses import dataclass

from mrsfi_runtime.kernel.commands import steer
from mrsfi_runtime.kernel.geometry import inside, well_inside
from mrsfi_runtime.kernel.goal_tasks.common import (
    AWAKE,
    CALM,
    NEVER,
    is_quiet,
    kth_best,
    needs_reaction,
    patience,
    too_many,
)
from mrsfi_runtime.kernel.guidance import leeway, pace
from mrsfi_runtime.kernel.state import RESERVE, GoalState, State, kernel
from mrsfi_runtime.model.mission import GoalTask


@dataclass(frozen=True, slots=True)
class StayWithinMissionArea(GoalTask):
    """Keep every member inside the mission area."""


@kernel
def is_outside(view: State, goal: GoalState, m: int) -> bool:  # noqa: ARG001 - as of all rules
    """Return whether a member is farther from the mission's centre than its radius."""
    robot, mission = view.robots[view.members[m].robot], view.mission
    return not inside(robot.x, robot.y, mission.x, mission.y, mission.radius)


@kernel
def nearness(world: State, goal: GoalState, m: int) -> float:  # noqa: ARG001 - as of all values
    """Return the square of a member's distance from the mission's centre, negated."""
    robot, mission = world.robots[world.members[m].robot], world.mission
    dx, dy = robot.x - mission.x, robot.y - mission.y
    return -(dx * dx + dy * dy)


has_left = too_many(is_outside)
decisive = kth_best(nearness)


@kernel
def violated(view: State, g: int) -> bool:
    """Return whether fewer members than required are inside the mission area."""
    if is_quiet(view, g):
        return False
    if len(view.quiet) > 0 and abs(view.quiet[g]) <= view.mission.tick:
        settle(view, g)
    return has_left(view, g)


@kernel
def settle(view: State, g: int) -> None:
    """Decide until when no member can be near the edge, nor has to turn back; else look later."""
    goal, mission, wait = view.goals[g], view.mission, NEVER
    for m in range(goal.first_member, goal.first_member + goal.n_members):
        step, trait = view.scopes[m].step, view.traits[view.members[m].robot]
        edge = (3.0 + trait.turn_width) * step + 2.0 * trait.position_noise
        left = (1.0 - RESERVE) * mission.radius - math.sqrt(-nearness(view, goal, m))
        wait = min(wait, patience(left, edge + step, step))
    view.quiet[g] = mission.tick + wait if wait >= CALM else -(mission.tick + AWAKE)


@kernel
def margin(world: State, g: int, least: float) -> tuple[float, int]:
    """Return how far inside the outermost required member is, and when that can be less."""
    left = world.mission.radius - math.sqrt(-decisive(world, g))
    return left, patience(left, least, world.longest[g])


@kernel
def react(ci: State, g: int) -> None:
    """Turn every member that is outside the mission area, or about to leave it, to its centre."""
    if not needs_reaction(ci, g):
        return
    goal = ci.goals[g]
    mission = ci.mission
    for m in range(goal.first_member, goal.first_member + goal.n_members):
        index = ci.members[m].robot
        robot = ci.robots[index]
        command = ci.commands[index]
        step = 2.0 * pace(ci, index)
        x, y = robot.x + step * command.heading_x, robot.y + step * command.heading_y
        if not well_inside(x, y, mission.x, mission.y, mission.radius, leeway(ci, index)):
            steer(ci, index, mission.x - robot.x, mission.y - robot.y)
