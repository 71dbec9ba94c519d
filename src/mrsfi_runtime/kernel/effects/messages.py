"""What becomes of messages that are held back: delayed ones arrive late, blocked ones are lost.

References
----------
Source paper, section III-B b).
"""

from mrsfi_runtime.kernel.compiling import kernel
from mrsfi_runtime.kernel.effects.belief import believe, note
from mrsfi_runtime.kernel.injections import (
    COUNT,
    DELAY,
    ENERGY,
    POSITION,
    SPEED,
    InjectionState,
    Plan,
)
from mrsfi_runtime.kernel.state import State


@kernel
def remember(ci: State, plan: Plan) -> None:
    """Remember what was believed of every property whose messages are held back now."""
    tick = ci.mission.tick
    for injection in plan.messages:
        if injection.start > tick:
            break
        if tick <= injection.finish:
            keep(ci, injection)


@kernel
def withhold(ci: State, plan: Plan) -> None:
    """Take back what was just delivered of every property whose messages are held back now."""
    tick = ci.mission.tick
    for injection in plan.messages:
        if injection.start > tick:
            break
        if tick <= injection.finish:
            hold_back(ci, plan, injection)


@kernel
def keep(ci: State, injection: InjectionState) -> None:
    """Remember what was believed of an injection's property before the delivery."""
    if injection.affected == POSITION:
        robot = ci.robots[injection.target]
        injection.kept_a = robot.x
        injection.kept_b = robot.y
        injection.kept_c = robot.z
    elif injection.affected == SPEED:
        injection.kept_a = ci.robots[injection.target].speed
    elif injection.affected == ENERGY:
        injection.kept_a = ci.robots[injection.target].energy
    elif injection.affected == COUNT:
        injection.kept_a = float(ci.sensors[injection.target].count)


@kernel
def hold_back(ci: State, plan: Plan, injection: InjectionState) -> None:
    """Replace what was just delivered by what is believed while the message is held back."""
    if injection.mode == DELAY and injection.n_held > 0:
        changed = delay(ci, plan, injection)
    else:
        changed = block(ci, injection)
    note(plan, injection, ci.mission.tick, changed)


@kernel
def block(ci: State, injection: InjectionState) -> bool:
    """Believe what was believed before; return whether that is something else."""
    return believe(
        ci,
        injection.affected,
        injection.target,
        injection.kept_a,
        injection.kept_b,
        injection.kept_c,
    )


@kernel
def delay(ci: State, plan: Plan, injection: InjectionState) -> bool:
    """Believe what arrives after its delay, and put what was just delivered under way."""
    a = injection.kept_a
    b = injection.kept_b
    c = injection.kept_c
    age = ci.mission.tick - injection.start
    slot = injection.first_held + 3 * (age % injection.n_held)
    if age >= injection.n_held:
        a = plan.held[slot]
        b = plan.held[slot + 1]
        c = plan.held[slot + 2]
    keep(ci, injection)
    plan.held[slot] = injection.kept_a
    plan.held[slot + 1] = injection.kept_b
    plan.held[slot + 2] = injection.kept_c
    return believe(ci, injection.affected, injection.target, a, b, c)
