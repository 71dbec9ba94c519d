"""Events that set faults off: they are judged in truth, and each happens once in a flight."""

from mrsfi_runtime.kernel.compiling import kernel
from mrsfi_runtime.kernel.geometry import inside
from mrsfi_runtime.kernel.goal_tasks.purpose import is_reached
from mrsfi_runtime.kernel.injections import Plan, TriggerState, WaitingState
from mrsfi_runtime.kernel.state import State
from mrsfi_runtime.model.faults import Event

VIOLATED, REACHED, ENTERED, EFFECT = map(int, Event)


@kernel
def arm(world: State, plan: Plan, violated: list[int], tick: int) -> None:
    """Note which events happen at a tick, and let begin at the next one what is due then.

    ``violated`` are the goals that truly are. What begins is moved to where it does: lists by start
    stay in order as far as they are read, since no start lies beyond the tick that is read.
    """
    for trigger in plan.triggers:
        if trigger.fired < 0 and happens(world, plan, violated, trigger):
            trigger.fired = tick
    for waiting in plan.waiting:
        trigger = plan.triggers[waiting.trigger]
        due = max(waiting.start, trigger.fired + 1 + trigger.delay)
        if trigger.fired >= 0 and due == tick + 1:
            begin(plan, waiting, due, min(waiting.finish, tick + waiting.most))


@kernel
def happens(world: State, plan: Plan, violated: list[int], trigger: TriggerState) -> bool:
    """Return whether what a trigger waits for is so."""
    if trigger.event == VIOLATED:
        return violated[trigger.of] == 1
    if trigger.event == REACHED:
        return is_reached(world, trigger.of)
    if trigger.event == ENTERED:
        robot = world.robots[trigger.of]
        return inside(robot.x, robot.y, trigger.x, trigger.y, trigger.radius)
    for source in range(trigger.first_source, trigger.first_source + trigger.n_sources):
        if plan.tallies[plan.sources[source]].changed > 0:
            return True
    return False


@kernel
def begin(plan: Plan, waiting: WaitingState, start: int, finish: int) -> None:
    """Give what was set off the window in which it is active."""
    place = waiting.place
    if waiting.listed == 0:
        plan.messages[place].start = start
        plan.messages[place].finish = finish
    elif waiting.listed == 1:
        plan.reports[place].start = start
        plan.reports[place].finish = finish
    elif waiting.listed == 2:
        plan.commands[place].start = start
        plan.commands[place].finish = finish
    else:
        plan.own[place].start = start
        plan.own[place].finish = finish
