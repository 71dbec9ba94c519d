"""What falsified reports do to the collective intelligence's local state.

Effects read the true value of the tick, so nothing accumulates and nothing has to be undone: at
``finish + 1`` the next delivery restores the property.

References
----------
Source paper, sections III-B b) and III-G (``executeFaults``).
"""

import math

from mrsfi_runtime.kernel.compiling import kernel
from mrsfi_runtime.kernel.effects.belief import Belief, believe, believed
from mrsfi_runtime.kernel.injections import (
    COST,
    DECREMENT,
    DECREMENT_PERCENT,
    ENERGY,
    FIXED,
    INCREMENT,
    INCREMENT_PERCENT,
    OBSTACLE,
    POSITION,
    RANDOM,
    InjectionState,
    Plan,
)
from mrsfi_runtime.kernel.randomness import choice, uniform
from mrsfi_runtime.kernel.state import State
from mrsfi_runtime.model.fault_types import Field

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
                value = falsified(ci, injection, true[0]), 0.0, 0.0
            believe(ci, plan, injection, true, value)


@kernel
def falsified(ci: State, injection: InjectionState, true: float) -> float:
    """Return the value that a fault makes of a true one, never below 0; zero is what is left.

    ``injection.a`` is the fixed value, step or percentage, as the mode defines it.
    """
    value = 0.0
    if injection.mode == RANDOM:
        value = drawn(ci, injection)
    elif injection.mode == FIXED:
        value = injection.a
    elif injection.mode == INCREMENT:
        value = true + injection.a
    elif injection.mode == DECREMENT:
        value = true - injection.a
    elif injection.mode == INCREMENT_PERCENT:
        value = true * (1.0 + injection.a / 100.0)
    elif injection.mode == DECREMENT_PERCENT:
        value = true * (1.0 - injection.a / 100.0)
    return max(value, 0.0)


@kernel
def drawn(ci: State, injection: InjectionState) -> float:
    """Return a uniform value between a random fault's bounds; all but energies are whole."""
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

    A random place is uniform in the mission disc, at height ``z``: radius × √u along a direction.
    """
    if injection.mode != RANDOM:
        return injection.a, injection.b, injection.c
    mission = ci.mission
    target = injection.target
    purpose = PURPOSES[injection.affected]
    turn = choice(len(ci.directions), mission.seed, mission.tick, target, purpose + 1)
    direction = ci.directions[turn]
    reach = mission.radius * math.sqrt(uniform(mission.seed, mission.tick, target, purpose))
    return mission.x + reach * direction.x, mission.y + reach * direction.y, z
