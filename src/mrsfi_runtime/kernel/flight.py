"""The tick of a flight, written once for every engine: all that happens, in its order.

A flight begins with forged commands (``issue``); then every tick moves the robots (``move``), sends
their messages (``send``), and has the collective intelligence answer them: it hears (``hear``),
reacts, and replies (``reply``). Over a bus, the simulation behind it moves and sends; and where a
team's own node is the collective intelligence, it stands between hearing and reply.

References
----------
Source paper, Figure 4. Its three unsynchronised threads (section V-D b) are one loop here.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple, get_type_hints

from mrsfi_runtime.kernel.commands import release
from mrsfi_runtime.kernel.compiling import kernel
from mrsfi_runtime.kernel.delivery import deliver
from mrsfi_runtime.kernel.effects.belief import falsify
from mrsfi_runtime.kernel.effects.commands import Orders, issue
from mrsfi_runtime.kernel.effects.own import disturb
from mrsfi_runtime.kernel.effects.triggers import arm
from mrsfi_runtime.kernel.forecast import ticks_left
from mrsfi_runtime.kernel.goal_tasks.margins import NEVER, NO_MARGIN
from mrsfi_runtime.kernel.goal_tasks.purpose import is_missed
from mrsfi_runtime.kernel.goal_tasks.reference import margin
from mrsfi_runtime.kernel.injections import OwnEffect, Plan
from mrsfi_runtime.kernel.state import State


class MissionFunctions(NamedTuple):
    """What the generated code of a mission brings to its flights, all goals in model order.

    ``progress`` brings that of the goals up to the tick of a state; ``check`` writes 1 for every
    goal that is violated in it, else 0; ``react`` lets every goal command its members, of which
    the first that claims a channel keeps it; ``apply`` lets a fault of a team's own type act.
    """

    progress: Callable[[State], None]
    check: Callable[[State, list[int]], None]
    react: Callable[[State], None]
    apply: OwnEffect


@dataclass(slots=True)
class Verdicts:
    """Which goals are violated at the present tick (0 or 1), and at how many ticks so far.

    Each list has an entry for each goal. ``phantom`` violations were believed and not true,
    ``masked`` ones true and not believed. ``missed`` counts from the tick on at which it was
    certain that the goal's purpose is not met, ``broken`` from the first tick on at which the goal
    is truly violated or missed, ``undetected`` from that on until the belief first shows a
    violation.

    ``margin`` is how far from being truly violated the goal was when it was nearest to it, up to
    its first violation, ``nearest`` the tick of that, ``due`` the first at which it can be less, or
    at which the goal can be missed without being violated.
    """

    is_true: list[int]
    is_believed: list[int]
    believed: list[int]
    true: list[int]
    phantom: list[int]
    masked: list[int]
    missed: list[int]
    broken: list[int]
    undetected: list[int]
    margin: list[float]
    nearest: list[int]
    due: list[int]


def no_verdicts(n_goals: int) -> Verdicts:
    """Return verdicts before the first tick."""
    counts = {name: [0] * n_goals for name in get_type_hints(Verdicts) if name != "margin"}
    return Verdicts(**counts, margin=[0.0] * n_goals)


@kernel
def answer(
    functions: MissionFunctions,
    world: State,
    ci: State,
    inbox: State,
    orders: Orders | State,
    plan: Plan,
    verdicts: Verdicts,
    tick: int,
) -> None:
    """Do all of a tick that follows when the robots have moved and their messages have arrived.

    ``inbox`` has the newest message of every topic; ``orders`` receive the commands for the
    motion of the tick after, ``verdicts`` what is violated, which they count.
    """
    hear(functions, world, ci, inbox, plan, verdicts, tick)
    functions.react(ci)
    reply(world, ci, orders, plan, verdicts, tick)


@kernel
def hear(
    functions: MissionFunctions,
    world: State,
    ci: State,
    inbox: State,
    plan: Plan,
    verdicts: Verdicts,
    tick: int,
) -> None:
    """Judge the truth of a tick, turn its messages into belief, and judge that.

    What an event of the tick sets off begins with the next one: commands that are issued now.
    """
    judge(functions, world, verdicts.is_true)
    perceive(functions, ci, inbox, plan, tick)
    judge(functions, ci, verdicts.is_believed)
    if len(plan.triggers) > 0:
        arm(world, plan, verdicts.is_true, tick)


@kernel
def reply(
    world: State, ci: State, orders: Orders | State, plan: Plan, verdicts: Verdicts, tick: int
) -> None:
    """Issue the commands of a tick that was reacted to, and count what was violated in it."""
    issue(ci, orders, plan, tick + 1)
    count(verdicts, world)


@kernel
def perceive(functions: MissionFunctions, ci: State, inbox: State, plan: Plan, tick: int) -> None:
    """Turn the messages of a tick into belief: delivery, then faults; all channels are free.

    References
    ----------
    Source paper, Figure 4: ``updateSystemState`` and ``executeFaults``.
    """
    ci.mission.tick = tick
    deliver(ci, inbox, plan)
    falsify(ci, plan)
    disturb(functions.apply, ci, inbox, plan)
    release(ci)


@kernel
def judge(functions: MissionFunctions, view: State, violated: list[int]) -> None:
    """Say which goals are violated in a state, after their progress."""
    functions.progress(view)
    functions.check(view, violated)


@kernel
def count(verdicts: Verdicts, world: State) -> None:
    """Count the violations of a tick, once per goal, and a tick of what is missed for good.

    What is missed without a violation, and margins, are looked at where they can be otherwise.
    """
    tick = world.mission.tick
    for goal in range(len(verdicts.is_true)):
        true = verdicts.is_true[goal]
        believed = verdicts.is_believed[goal]
        if true or believed:
            verdicts.true[goal] += true
            verdicts.believed[goal] += believed
            verdicts.phantom[goal] += believed and not true
            verdicts.masked[goal] += true and not believed
        is_due = tick >= verdicts.due[goal]
        if verdicts.missed[goal] > 0 or ((true or is_due) and is_missed(world, goal, true)):
            verdicts.missed[goal] += 1
            true = 1
        if true or verdicts.broken[goal] > 0:
            is_hidden = not believed and verdicts.undetected[goal] == verdicts.broken[goal]
            verdicts.undetected[goal] += is_hidden
            verdicts.broken[goal] += 1
        if is_due:
            measure(verdicts, world, goal)


@kernel
def measure(verdicts: Verdicts, world: State, goal: int) -> None:
    """Note how far a goal is from being violated, if it was never nearer nor violated before.

    The last tick is looked at in any case, unless all is said before.
    """
    tick = world.mission.tick
    least = NO_MARGIN if verdicts.due[goal] == 0 else verdicts.margin[goal]
    left, wait = margin(world, goal, world.goals[goal].task, least)
    is_nearer = left < least and verdicts.true[goal] == verdicts.is_true[goal]
    if is_nearer or verdicts.due[goal] == 0:
        verdicts.margin[goal] = left
        verdicts.nearest[goal] = tick
    is_over = verdicts.true[goal] > 0 and verdicts.missed[goal] > 0
    verdicts.due[goal] = NEVER if is_over else tick + min(wait, max(ticks_left(world), 1))
