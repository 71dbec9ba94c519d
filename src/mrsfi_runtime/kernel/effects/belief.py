"""How effects change the local state, and keep account of it."""

from typing import TypeAlias

from mrsfi_runtime.kernel.compiling import kernel
from mrsfi_runtime.kernel.injections import (
    COST,
    COUNT,
    ENERGY,
    OBSTACLE,
    POSITION,
    SPEED,
    InjectionState,
    OwnFault,
    Plan,
)
from mrsfi_runtime.kernel.state import State

Belief: TypeAlias = tuple[float, float, float]
"""What is believed of a property: a place, or one number and zeros."""


@kernel
def believed(ci: State, injection: InjectionState) -> Belief:
    """Return what is believed of an injection's property."""
    target = injection.target
    if injection.affected == POSITION:
        robot = ci.robots[target]
        return robot.x, robot.y, robot.z
    if injection.affected == OBSTACLE:
        return ci.obstacles[target].x, ci.obstacles[target].y, 0.0
    if injection.affected == SPEED:
        value = ci.robots[target].speed
    elif injection.affected == ENERGY:
        value = ci.robots[target].energy
    elif injection.affected == COUNT:
        value = float(ci.sensors[target].count)
    elif injection.affected == COST:
        value = ci.sensors[target].cost
    else:
        value = ci.sensors[target].rate
    return value, 0.0, 0.0


@kernel
def believe(
    ci: State, plan: Plan, injection: InjectionState, before: Belief, value: Belief
) -> None:
    """Believe another value of an injection's property, and note whether it is another."""
    target = injection.target
    a, b, c = value
    if injection.affected == POSITION:
        robot = ci.robots[target]
        robot.x = a
        robot.y = b
        robot.z = c
    elif injection.affected == OBSTACLE:
        ci.map.is_wrong = 1
        ci.obstacles[target].x = a
        ci.obstacles[target].y = b
    elif injection.affected == SPEED:
        ci.robots[target].speed = a
    elif injection.affected == ENERGY:
        ci.robots[target].energy = a
    elif injection.affected == COUNT:
        a = float(int(a))
        ci.sensors[target].count = int(a)
    elif injection.affected == COST:
        ci.sensors[target].cost = a
    else:
        ci.sensors[target].rate = a
    note(plan, injection, ci.mission.tick, a != before[0] or b != before[1])


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
