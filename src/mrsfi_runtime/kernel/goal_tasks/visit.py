"""Visit: every member reaches a point no later than a deadline."""

from dataclasses import dataclass, replace
from typing import ClassVar

from mrsfi_runtime.kernel.commands import set_speed
from mrsfi_runtime.kernel.goal_tasks.common import (
    NEVER,
    NO_MARGIN,
    depth,
    grace_of,
    kth_best,
    note_presence,
    patience,
    too_many,
)
from mrsfi_runtime.kernel.guidance import approach, is_surely_at
from mrsfi_runtime.kernel.state import GoalState, State, kernel
from mrsfi_runtime.model.fault_types import Range
from mrsfi_runtime.model.mission import Area, Coordinates, Goal, GoalTask, Terms


@dataclass(frozen=True, slots=True)
class Visit(GoalTask):
    """Have every member within tolerance of a point no later than the deadline tick."""

    spares: ClassVar[Range] = Range.TICKS
    coordinates: Coordinates
    tolerance: float
    deadline: int

    def terms(self, goal: Goal) -> Terms:
        """Return the point, the tolerance and the deadline."""
        return replace(GoalTask.terms(self, goal), area=Area(goal.id, self.coordinates, 0.0))


progress = note_presence


@kernel
def is_absent(view: State, goal: GoalState, m: int) -> bool:  # noqa: ARG001 - as of all rules
    """Return whether a member has not yet been at the point."""
    return view.members[m].reached == 0


is_awaited = too_many(is_absent)


@kernel
def violated(view: State, g: int) -> bool:
    """Return whether a required member has not been at the point by the deadline."""
    return view.mission.tick >= view.goals[g].deadline and is_awaited(view, g)


@kernel
def earliness(world: State, goal: GoalState, m: int) -> float:  # noqa: ARG001 - as of all values
    """Return minus the least number of ticks before a member can be at the point."""
    member = world.members[m]
    if member.reached == 1:
        return 0.0
    robot = world.robots[member.robot]
    return -float(patience(-depth(world, m), 0.0, robot.max_speed))


decisive = kth_best(earliness)


@kernel
def margin(world: State, g: int, least: float) -> tuple[float, int]:
    """Return the ticks to spare when the last required member arrives, or minus how late it is.

    It is undefined before the deadline if a member is awaited. If one still is, it is late.
    """
    left = world.goals[g].deadline + grace_of(world, g) - world.mission.tick
    wait = int(-decisive(world, g))
    if wait == 0:
        return (float(left) if least == NO_MARGIN else least), NEVER
    if left <= 0:
        return left - 1.0, max(wait - 1, 1)
    return NO_MARGIN, min(wait, left)


@kernel
def may_have_missed(ci: State, goal: GoalState, m: int) -> bool:
    """Return whether a member that reports inexactly was at the point only by belief until now."""
    index = ci.members[m].robot
    if ci.traits[index].position_noise <= 0.0:
        return False
    if is_surely_at(ci, index, goal.x, goal.y, goal.tolerance):
        ci.aims[m] = 1
    return ci.aims[m] == 0


@kernel
def react(ci: State, g: int) -> None:
    """Head for the point until it has been reached, with a last step no longer than needed."""
    goal = ci.goals[g]
    for m in range(goal.first_member, goal.first_member + goal.n_members):
        member = ci.members[m]
        if member.reached == 0 or may_have_missed(ci, goal, m):
            approach(ci, member.robot, goal.x, goal.y)
        else:
            set_speed(ci, member.robot, ci.robots[member.robot].nominal_speed)
