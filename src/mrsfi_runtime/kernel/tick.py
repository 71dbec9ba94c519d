"""What the collective intelligence does with the messages of one tick, before its goals.

References
----------
Source paper, Figure 4: ``updateSystemState`` and ``executeFaults``.
"""

from mrsfi_runtime.kernel.commands import release
from mrsfi_runtime.kernel.compiling import kernel
from mrsfi_runtime.kernel.delivery import deliver
from mrsfi_runtime.kernel.effects import falsify
from mrsfi_runtime.kernel.goal_tasks.progress import progress
from mrsfi_runtime.kernel.injections import Plan
from mrsfi_runtime.kernel.state import State


@kernel
def perceive(ci: State, inbox: State, plan: Plan, tick: int) -> None:
    """Turn the messages of a tick into belief: delivery, faults, progress of the goals.

    Parameters
    ----------
    ci
        Local state; afterwards it is that of ``tick``, with all command channels free.
    inbox
        The newest message of every topic.
    plan
        Faults of this run.
    tick
        The tick.
    """
    ci.mission.tick = tick
    deliver(ci, inbox, plan)
    falsify(ci, inbox, plan)
    progress(ci)
    release(ci)
