"""Stay: every member stays inside an area once it has entered."""

from dataclasses import dataclass
from typing import ClassVar

from mrsfi_runtime.kernel.goal_tasks.common import (
    NEVER,
    NO_MARGIN,
    depth,
    kth_best,
    note_presence,
    patience,
    roam_area,
    too_many,
)
from mrsfi_runtime.kernel.state import GoalState, State, kernel
from mrsfi_runtime.model.mission import Area, GoalTask


@dataclass(frozen=True, slots=True)
class Stay(GoalTask):
    """Keep every member inside the area from its first entry on."""

    keeps_robots: ClassVar[bool] = True
    area: Area


progress = note_presence
react = roam_area


@kernel
def is_outside(view: State, goal: GoalState, m: int) -> bool:  # noqa: ARG001 - as of all rules
    """Return whether a member is outside the area."""
    return view.members[m].since != view.mission.tick


@kernel
def has_left(view: State, goal: GoalState, m: int) -> bool:
    """Return whether a member has left the area after it first entered."""
    return view.members[m].reached == 1 and is_outside(view, goal, m)


@kernel
def depth_inside(world: State, goal: GoalState, m: int) -> float:  # noqa: ARG001 - as of all values
    """Return how far inside the area a member is, undefined before it has entered."""
    return depth(world, m) if world.members[m].reached == 1 else NO_MARGIN


violated = too_many(has_left)
is_unfinished = too_many(is_outside)
decisive = kth_best(depth_inside)


@kernel
def margin(world: State, g: int, least: float) -> tuple[float, int]:
    """Return how far inside the area the outermost required member is, if enough have entered.

    The depth of a member is infinite until it enters, at the earliest after ``wait``.
    """
    goal = world.goals[g]
    left = decisive(world, g)
    wait = NEVER
    for m in range(goal.first_member, goal.first_member + goal.n_members):
        member = world.members[m]
        if member.reached == 0:
            robot = world.robots[member.robot]
            wait = min(wait, patience(-depth(world, m), 0.0, robot.max_speed))
    if left < NO_MARGIN:
        wait = min(wait, patience(left, min(left, least), world.longest[g]))
    return left, wait
