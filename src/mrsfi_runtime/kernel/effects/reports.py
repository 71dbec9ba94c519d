"""What falsified reports do to the collective intelligence's local state.

Effects read the true value of the tick, so nothing accumulates and nothing has to be undone: at
``finish + 1`` the next delivery restores the property.

References
----------
Source paper, sections III-B b) and III-G (``executeFaults``).
"""

import math

from mrsfi_runtime.kernel.compiling import kernel
from mrsfi_runtime.kernel.directions import N_DIRECTIONS
from mrsfi_runtime.kernel.effects.belief import believe, note
from mrsfi_runtime.kernel.injections import (
    COST,
    COUNT,
    DECREMENT,
    DECREMENT_PERCENT,
    ENERGY,
    FIXED,
    INCREMENT,
    INCREMENT_PERCENT,
    OBSTACLE,
    POSITION,
    RANDOM,
    RATE,
    SPEED,
    InjectionState,
    Plan,
)
from mrsfi_runtime.kernel.randomness import (
    PURPOSE_COST,
    PURPOSE_COUNT,
    PURPOSE_ENERGY,
    PURPOSE_OBSTACLE_ANGLE,
    PURPOSE_OBSTACLE_RADIUS,
    PURPOSE_POSITION_ANGLE,
    PURPOSE_POSITION_RADIUS,
    PURPOSE_RATE,
    PURPOSE_SPEED,
    choice,
    uniform,
)
from mrsfi_runtime.kernel.state import State


@kernel
def falsify(ci: State, inbox: State, plan: Plan) -> None:
    """Apply every active fault of a known mode that changes a value of the local state."""
    tick = ci.mission.tick
    for injection in plan.reports:
        if injection.start > tick:
            break
        if tick <= injection.finish:
            if injection.affected == POSITION:
                changed = misplace_robot(ci, injection)
            elif injection.affected == OBSTACLE:
                changed = misplace_obstacle(ci, injection)
            else:
                value = falsified(ci, injection, true_value(ci, inbox, injection))
                changed = believe(ci, injection.affected, injection.target, value, 0.0, 0.0)
            note(plan, injection, tick, changed)


@kernel
def true_value(ci: State, inbox: State, injection: InjectionState) -> float:
    """Return what would be believed of a property without the fault."""
    target = injection.target
    if injection.affected == SPEED:
        return inbox.robots[target].speed
    if injection.affected == ENERGY:
        return inbox.robots[target].energy
    if injection.affected == COUNT:
        return float(inbox.sensors[target].count)
    if injection.affected == RATE:
        return ci.sensors[target].nominal_rate
    return ci.sensors[target].nominal_cost


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
    if injection.affected == ENERGY:
        return between(ci, injection, PURPOSE_ENERGY)
    if injection.affected == COST:
        return between(ci, injection, PURPOSE_COST)
    if injection.affected == SPEED:
        return whole_between(ci, injection, PURPOSE_SPEED)
    if injection.affected == RATE:
        return whole_between(ci, injection, PURPOSE_RATE)
    return whole_between(ci, injection, PURPOSE_COUNT)


@kernel
def between(ci: State, injection: InjectionState, purpose: int) -> float:
    """Return a uniform value between a random fault's bounds."""
    mission = ci.mission
    share = uniform(mission.seed, mission.tick, injection.target, purpose)
    return injection.a + (injection.b - injection.a) * share


@kernel
def whole_between(ci: State, injection: InjectionState, purpose: int) -> float:
    """Return a uniform whole number between a random fault's bounds."""
    mission = ci.mission
    low = math.ceil(injection.a)
    n = math.floor(injection.b) - low + 1
    return float(low + choice(max(n, 1), mission.seed, mission.tick, injection.target, purpose))


@kernel
def misplace_robot(ci: State, injection: InjectionState) -> bool:
    """Believe a robot elsewhere; return whether that changed anything."""
    x = injection.a
    y = injection.b
    z = injection.c
    if injection.mode == RANDOM:
        x, y = drawn_place(ci, injection, PURPOSE_POSITION_RADIUS, PURPOSE_POSITION_ANGLE)
        z = ci.robots[injection.target].z
    return believe(ci, POSITION, injection.target, x, y, z)


@kernel
def misplace_obstacle(ci: State, injection: InjectionState) -> bool:
    """Move an obstacle on the server's map; return whether that changed anything."""
    x = injection.a
    y = injection.b
    if injection.mode == RANDOM:
        x, y = drawn_place(ci, injection, PURPOSE_OBSTACLE_RADIUS, PURPOSE_OBSTACLE_ANGLE)
    ci.map.is_wrong = 1
    obstacle = ci.obstacles[injection.target]
    obstacle.x = x
    obstacle.y = y
    return x != obstacle.model_x or y != obstacle.model_y


@kernel
def drawn_place(
    ci: State, injection: InjectionState, radius: int, angle: int
) -> tuple[float, float]:
    """Return a place that is uniform in the mission disc: radius × √u along a direction."""
    mission = ci.mission
    target = injection.target
    direction = ci.directions[choice(N_DIRECTIONS, mission.seed, mission.tick, target, angle)]
    reach = mission.radius * math.sqrt(uniform(mission.seed, mission.tick, target, radius))
    return mission.x + reach * direction.x, mission.y + reach * direction.y
