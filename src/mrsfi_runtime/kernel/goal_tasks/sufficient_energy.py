"""SufficientEnergy: every member has the energy to complete the mission."""

from dataclasses import dataclass
from typing import ClassVar

from mrsfi_runtime.kernel.commands import set_speed
from mrsfi_runtime.kernel.forecast import endurance, energy_reserve, sensor_power, ticks_left
from mrsfi_runtime.kernel.goal_tasks.common import AWAKE, NEVER, NO_MARGIN, kth_best, too_many
from mrsfi_runtime.kernel.state import RESERVE, GoalState, State, kernel
from mrsfi_runtime.model.fault_types import Range
from mrsfi_runtime.model.mission import GoalTask


@dataclass(frozen=True, slots=True)
class SufficientEnergy(GoalTask):
    """Keep enough energy in every member to complete the mission."""

    spares: ClassVar[Range] = Range.ENERGY


@kernel
def energy(world: State, goal: GoalState, m: int) -> float:  # noqa: ARG001 - as of all values
    """Return the energy that a member has left."""
    return world.robots[world.members[m].robot].energy


@kernel
def has_none(world: State, goal: GoalState, m: int) -> bool:
    """Return whether a member has no energy left."""
    return energy(world, goal, m) <= 0.0


@kernel
def lacks(view: State, goal: GoalState, m: int) -> bool:
    """Return whether a member is exhausted, or its energy below the forecast need."""
    return energy_reserve(view, view.members[m].robot) < 0.0 or has_none(view, goal, m)


are_short = too_many(lacks)
is_exhausted = too_many(has_none)
decisive = kth_best(energy)


@kernel
def violated(view: State, g: int) -> bool:
    """Return whether fewer members than required have the energy that the forecast needs."""
    tick = view.mission.tick
    if len(view.quiet) > 0 and view.map.misled < tick:
        if view.quiet[g] > tick:
            return False
        if abs(view.quiet[g]) <= tick:
            view.quiet[g] = NEVER if is_secure(view, g) else -(tick + AWAKE)
    return are_short(view, g)


@kernel
def is_secure(view: State, g: int) -> bool:
    """Return whether the energy of every member lasts to the end, whatever the robots do."""
    goal = view.goals[g]
    for m in range(goal.first_member, goal.first_member + goal.n_members):
        index = view.members[m].robot
        if view.robots[index].energy <= 0.0 or endurance(view, index) <= ticks_left(view) + 1:
            return False
    return True


@kernel
def margin(world: State, g: int, least: float) -> tuple[float, int]:  # noqa: ARG001 - as of all tasks
    """Return the least energy of a required member at the end of the mission."""
    goal = world.goals[g]
    wait = NEVER
    for m in range(goal.first_member, goal.first_member + goal.n_members):
        wait = min(wait, endurance(world, world.members[m].robot))
    return (NO_MARGIN if ticks_left(world) > 0 else decisive(world, g)), wait


@kernel
def react(ci: State, g: int) -> None:
    """Control every member's speed to its nominal one, or to what its energy allows.

    The control loop uses the reported speed (sent + wanted − believed), so a false report changes
    the motion of a real robot. It starts from the speed sent, forged or not, so no error builds
    up during a forged stop. A reserve of the energy is left unspent.
    """
    goal = ci.goals[g]
    left = ticks_left(ci)
    for m in range(goal.first_member, goal.first_member + goal.n_members):
        index = ci.members[m].robot
        robot = ci.robots[index]
        wanted = robot.nominal_speed
        if left > 0 and robot.energy_per_distance > 0.0:
            spare = (1.0 - RESERVE) * robot.energy / left - sensor_power(ci, index)
            wanted = min(wanted, max(spare / robot.energy_per_distance, 0.0))
        set_speed(ci, index, ci.commands[index].sent_speed + wanted - robot.speed)
