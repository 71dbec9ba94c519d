"""SufficientEnergy: every member has the energy to complete the mission."""

from dataclasses import dataclass
from typing import ClassVar

from mrsfi_runtime.kernel.commands import set_speed
from mrsfi_runtime.kernel.forecast import endurance, energy_reserve, sensor_power, ticks_left
from mrsfi_runtime.kernel.goal_tasks.common import NEVER, NO_MARGIN
from mrsfi_runtime.kernel.state import RESERVE, State, kernel
from mrsfi_runtime.model.fault_types import Range
from mrsfi_runtime.model.mission import GoalTask


@dataclass(frozen=True, slots=True)
class SufficientEnergy(GoalTask):
    """Keep enough energy in every member to complete the mission."""

    spares: ClassVar[Range] = Range.ENERGY


@kernel
def violated(view: State, g: int) -> bool:
    """Return whether a member is exhausted, or its energy below the forecast need."""
    goal = view.goals[g]
    for m in range(goal.first_member, goal.first_member + goal.n_members):
        if energy_reserve(view, view.members[m].robot) < 0.0:
            return True
    return is_exhausted(view, g)


@kernel
def is_exhausted(world: State, g: int) -> bool:
    """Return whether a member has no energy left."""
    goal = world.goals[g]
    for m in range(goal.first_member, goal.first_member + goal.n_members):
        if world.robots[world.members[m].robot].energy <= 0.0:
            return True
    return False


@kernel
def margin(world: State, g: int, least: float) -> tuple[float, int]:  # noqa: ARG001 - as of all tasks
    """Return the least energy of a member at the end of the mission."""
    goal = world.goals[g]
    left = NO_MARGIN
    wait = NEVER
    for m in range(goal.first_member, goal.first_member + goal.n_members):
        index = world.members[m].robot
        left = min(left, world.robots[index].energy)
        wait = min(wait, endurance(world, index))
    return (NO_MARGIN if ticks_left(world) > 0 else left), wait


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
