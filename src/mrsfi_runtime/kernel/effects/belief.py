"""How effects change the local state, and keep account of it."""

from mrsfi_runtime.kernel.compiling import kernel
from mrsfi_runtime.kernel.injections import (
    COST,
    ENERGY,
    POSITION,
    RATE,
    SPEED,
    InjectionState,
    OwnFault,
    Plan,
)
from mrsfi_runtime.kernel.state import State


@kernel
def believe(ci: State, affected: int, target: int, a: float, b: float, c: float) -> bool:
    """Set one reported property of the local state; return whether that changed it."""
    if affected == POSITION:
        robot = ci.robots[target]
        changed = robot.x != a or robot.y != b
        robot.x = a
        robot.y = b
        robot.z = c
        return changed
    if affected == SPEED:
        changed = ci.robots[target].speed != a
        ci.robots[target].speed = a
        return changed
    if affected == ENERGY:
        changed = ci.robots[target].energy != a
        ci.robots[target].energy = a
        return changed
    if affected == RATE:
        changed = ci.sensors[target].rate != a
        ci.sensors[target].rate = a
        return changed
    if affected == COST:
        changed = ci.sensors[target].cost != a
        ci.sensors[target].cost = a
        return changed
    changed = ci.sensors[target].count != int(a)
    ci.sensors[target].count = int(a)
    return changed


@kernel
def note(plan: Plan, injection: InjectionState | OwnFault, tick: int, changed: bool) -> None:
    """Count a tick at which a fault was active, and one at which it changed something."""
    tally = plan.tallies[injection.fault]
    if tally.last_applied != tick:
        tally.last_applied = tick
        tally.applied += 1
    if changed and tally.last_changed != tick:
        tally.last_changed = tick
        tally.changed += 1
