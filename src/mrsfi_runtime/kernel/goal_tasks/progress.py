"""The progress of all goals of a mission."""

from mrsfi_runtime.kernel.compiling import kernel
from mrsfi_runtime.kernel.goal_tasks import gather_samples, patrol, stay, track, visit
from mrsfi_runtime.kernel.goal_tasks.table import TASKS
from mrsfi_runtime.kernel.state import State

_GATHER_SAMPLES = TASKS.index(gather_samples.GatherSamples)
_PATROL = TASKS.index(patrol.Patrol)
_VISIT = TASKS.index(visit.Visit)
_TRACK = TASKS.index(track.Track)
_STAY = TASKS.index(stay.Stay)


@kernel
def progress(view: State) -> None:
    """Bring the progress of every goal up to the tick of a state, before goals are checked."""
    for g in range(len(view.goals)):
        task = view.goals[g].task
        if task == _GATHER_SAMPLES:
            gather_samples.progress(view, g)
        elif task == _PATROL:
            patrol.progress(view, g)
        elif task == _VISIT:
            visit.progress(view, g)
        elif task == _TRACK:
            track.progress(view, g)
        elif task == _STAY:
            stay.progress(view, g)
