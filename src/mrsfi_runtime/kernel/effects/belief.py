"""How effects change the local state, and keep account of it.

Effects read the true value of the tick, so nothing accumulates and nothing has to be undone: at
``finish + 1`` the next delivery restores the property.

References
----------
Source paper, sections III-B b) and III-G (``executeFaults``).
"""

import math
from typing import TypeAlias

from mrsfi_runtime.kernel.compiling import kernel
from mrsfi_runtime.kernel.geometry import scattered
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
from mrsfi_runtime.kernel.randomness import choice, uniform
from mrsfi_runtime.kernel.state import State
from mrsfi_runtime.model.fault_types import Field

Belief: TypeAlias = tuple[float, float, float]
"""What is believed of a property: a place, or one number and zeros."""

_PURPOSES = {
    Field.POSITION: 8,
    Field.SPEED: 6,
    Field.ENERGY: 4,
    Field.COUNT: 12,
    Field.RATE: 7,
    Field.COST: 5,
    Field.OBSTACLE: 10,
}
PURPOSES = tuple(_PURPOSES[affected] for affected in sorted(_PURPOSES))
"""Purpose under which a random value of each property is drawn, by the number of its ``Field``.

Of a place it is the distance from the middle; its direction is drawn under the purpose after.
"""


@kernel
def falsify(ci: State, plan: Plan) -> None:
    """Apply every active fault of a known mode that changes a value of the local state.

    What was just delivered is the true value: conflicting faults are never active at once.
    """
    tick = ci.mission.tick
    for injection in plan.reports:
        if injection.start > tick:
            break
        if tick <= injection.finish:
            true = believed(ci, injection)
            if injection.affected in (POSITION, OBSTACLE):
                value = place(ci, injection, true[2])
            else:
                value = max(number(ci, injection, true[0]), 0.0), 0.0, 0.0
            believe(ci, plan, injection, true, value)


@kernel
def number(ci: State, injection: InjectionState, true: float) -> float:
    """Return the number that a fault makes of a true one.

    Random ones are uniform between the fault's bounds, and whole, but for energies.
    """
    if injection.is_random == 0:
        return injection.a + injection.b * true
    mission = ci.mission
    target = injection.target
    purpose = PURPOSES[injection.affected]
    if injection.affected in (ENERGY, COST):
        share = uniform(mission.seed, mission.tick, target, purpose)
        return injection.a + (injection.b - injection.a) * share
    low = math.ceil(injection.a)
    n = max(math.floor(injection.b) - low + 1, 1)
    return float(low + choice(n, mission.seed, mission.tick, target, purpose))


@kernel
def place(ci: State, injection: InjectionState, z: float) -> Belief:
    """Return where a fault puts a robot or an obstacle.

    A random place is anywhere in the mission disc, at height ``z``.
    """
    if injection.is_random == 0:
        return injection.a, injection.b, injection.c
    mission = ci.mission
    purpose = PURPOSES[injection.affected]
    x, y = scattered(ci, mission.x, mission.y, mission.radius, injection.target, purpose)
    return x, y, z


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
        if tally.changed == 0:
            tally.first_changed = tick
        tally.last_changed = tick
        tally.changed += 1
