"""Whether the purpose of a goal is certainly not met: what came of it in the end, in truth."""

from mrsfi_runtime.kernel.compiling import kernel
from mrsfi_runtime.kernel.forecast import ticks_left
from mrsfi_runtime.kernel.goal_tasks import gather_samples, stay, sufficient_energy, track, visit
from mrsfi_runtime.kernel.goal_tasks.presence import is_awaited
from mrsfi_runtime.kernel.goal_tasks.table import TASKS
from mrsfi_runtime.kernel.state import State

ENERGY = TASKS.index(sufficient_energy.SufficientEnergy)
SAMPLES = TASKS.index(gather_samples.GatherSamples)
TRACK = TASKS.index(track.Track)
STAY = TASKS.index(stay.Stay)
VISIT = TASKS.index(visit.Visit)


@kernel
def is_missed(world: State, g: int, violated: int) -> bool:
    """Return whether it is certain from this tick on that a goal's purpose is not met.

    For most tasks that is the first violation, which no later tick makes up for. Violations of
    SufficientEnergy and GatherSamples are forecasts, and do not count; Track and Stay may also
    have come to nothing when the mission ends. ``violated`` is what the goal's check says of the
    true state, 0 or 1.
    """
    task = world.goals[g].task
    if task == ENERGY:
        return sufficient_energy.is_exhausted(world, g)
    if task == SAMPLES:
        return gather_samples.is_out_of_reach(world, g)
    if violated == 0 and ticks_left(world) == 0:
        if task == TRACK:
            return track.is_unfinished(world, g)
        if task == STAY:
            return is_awaited(world, g)
    return violated == 1


@kernel
def is_reached(world: State, g: int) -> bool:
    """Return whether a goal has its samples, or its robots were at its point, or at the last."""
    goal = world.goals[g]
    if goal.task == SAMPLES:
        return goal.count >= goal.target
    if goal.task == VISIT:
        return not is_awaited(world, g)
    return goal.task == TRACK and not track.is_unfinished(world, g)
