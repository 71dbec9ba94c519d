"""Patrol: every member is inside an area, or its next one, at least once in each period."""

from dataclasses import dataclass
from typing import ClassVar

from mrsfi_runtime.kernel.goal_tasks.common import (
    depth,
    kth_best,
    note_presence,
    patience,
    roam_area,
    too_many,
)
from mrsfi_runtime.kernel.state import GoalState, State, kernel
from mrsfi_runtime.model.fault_types import Range
from mrsfi_runtime.model.mission import Area, GoalTask


@dataclass(frozen=True, slots=True)
class Patrol(GoalTask):
    """Have every member inside the area at least once in each period of ticks.

    Instead of an area it can have a route: areas in order, in a loop. A member that has been inside
    its next area has the period to reach the one after it.
    """

    keeps_robots: ClassVar[bool] = True
    spares: ClassVar[Range] = Range.TICKS
    area: Area | None = None
    period: int = 1
    route: tuple[Area, ...] = ()


progress = note_presence
react = roam_area


@kernel
def is_overdue(view: State, goal: GoalState, m: int) -> bool:
    """Return whether a member has not been inside its next area for one period."""
    return view.mission.tick - view.members[m].since >= goal.period


@kernel
def last_inside(view: State, goal: GoalState, m: int) -> float:  # noqa: ARG001 - as of all values
    """Return the tick at which a member was last inside what then was its next area."""
    return float(view.members[m].since)


@kernel
def soonest(world: State, goal: GoalState, m: int) -> float:
    """Return the tick at which a member can first use up its whole period outside.

    With a single area, one that is inside has to leave it first.
    """
    member = world.members[m]
    stays = 0
    if member.since == world.mission.tick and world.routes[m].n_areas == 1:
        robot = world.robots[member.robot]
        stays = patience(depth(world, m), 0.0, robot.max_speed) - 1
    return float(member.since + stays + goal.period - 1)


violated = too_many(is_overdue)
decisive = kth_best(last_inside)
due = kth_best(soonest)


@kernel
def margin(world: State, g: int, least: float) -> tuple[float, int]:
    """Return the ticks to spare of the required member that was last inside the longest ago.

    A member has at least ``soonest`` minus a later tick to spare then, so the k-th best of these
    bounds the margin at that tick.
    """
    tick = world.mission.tick
    left = world.goals[g].period - 1 - (tick - decisive(world, g))
    return left, max(int(due(world, g)) - tick - int(min(left, least)), 1)
