"""What active faults do to the collective intelligence's local state, and to its commands.

Effects read the true value of the tick, so nothing accumulates and nothing has to be
undone: at ``finish + 1`` the next delivery restores the property, and the collective
intelligence's own last command holds again.

References
----------
Source paper, sections III-B b) and III-G (``executeFaults``).
"""

import math
from dataclasses import dataclass

from mrsfi_runtime.kernel.compiling import kernel
from mrsfi_runtime.kernel.delivery import believe, note
from mrsfi_runtime.kernel.directions import N_DIRECTIONS
from mrsfi_runtime.kernel.injections import (
    ACTIVATE,
    ACTIVATION,
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
    RATE,
    START,
    InjectionState,
    Plan,
)
from mrsfi_runtime.kernel.randomness import (
    PURPOSE_COST,
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
from mrsfi_runtime.kernel.state import CommandState, State, SwitchState


@dataclass(slots=True)
class Orders:
    """What leaves for the simulation: one command per robot, one switch per sensor."""

    commands: list[CommandState]
    switches: list[SwitchState]


@kernel
def falsify(ci: State, inbox: State, plan: Plan) -> None:
    """Apply every active fault that changes a value of the local state."""
    tick = ci.mission.tick
    for injection in plan.reports:
        if injection.start > tick:
            break
        if tick <= injection.finish:
            if injection.affected in (POSITION, OBSTACLE):
                changed = misplace(ci, injection)
            elif injection.affected in (RATE, COST):
                changed = misjudge_sensor(ci, injection)
            else:
                changed = misreport_robot(ci, inbox, injection)
            note(plan, injection, tick, changed)


@kernel
def misreport_robot(ci: State, inbox: State, injection: InjectionState) -> bool:
    """Falsify the reported speed or energy of a robot; return whether it changed."""
    sent = inbox.robots[injection.target]
    seed = ci.mission.seed
    tick = ci.mission.tick
    if injection.affected == ENERGY:
        drawn = between(injection, seed, tick, PURPOSE_ENERGY)
        value = falsified(injection.mode, sent.energy, injection.a, drawn)
    else:
        drawn = whole_between(injection, seed, tick, PURPOSE_SPEED)
        value = falsified(injection.mode, sent.speed, injection.a, drawn)
    return believe(ci, injection.affected, injection.target, value, 0.0, 0.0)


@kernel
def misjudge_sensor(ci: State, injection: InjectionState) -> bool:
    """Falsify the believed rate or cost of a sensor; return whether it changed."""
    sensor = ci.sensors[injection.target]
    seed = ci.mission.seed
    tick = ci.mission.tick
    if injection.affected == COST:
        drawn = between(injection, seed, tick, PURPOSE_COST)
        sensor.cost = falsified(injection.mode, sensor.nominal_cost, injection.a, drawn)
        return sensor.cost != sensor.nominal_cost
    drawn = whole_between(injection, seed, tick, PURPOSE_RATE)
    sensor.rate = falsified(injection.mode, sensor.nominal_rate, injection.a, drawn)
    return sensor.rate != sensor.nominal_rate


@kernel
def falsified(mode: int, true: float, a: float, drawn: float) -> float:
    """Return the value that a fault makes of a true one, never below 0.

    Parameters
    ----------
    mode
        Number of ``Mode``: random, zero, fixed, increment or decrement.
    true
        Value without the fault.
    a
        Fixed value, step or percentage, as the mode defines it.
    drawn
        Value of the random mode.
    """
    value = 0.0
    if mode == RANDOM:
        value = drawn
    elif mode == FIXED:
        value = a
    elif mode == INCREMENT:
        value = true + a
    elif mode == DECREMENT:
        value = true - a
    elif mode == INCREMENT_PERCENT:
        value = true * (1.0 + a / 100.0)
    elif mode == DECREMENT_PERCENT:
        value = true * (1.0 - a / 100.0)
    return max(value, 0.0)


@kernel
def between(injection: InjectionState, seed: int, tick: int, purpose: int) -> float:
    """Return a uniform value between a random fault's bounds; 0 for other modes."""
    if injection.mode != RANDOM:
        return 0.0
    return injection.a + (injection.b - injection.a) * uniform(
        seed, tick, injection.target, purpose
    )


@kernel
def whole_between(injection: InjectionState, seed: int, tick: int, purpose: int) -> float:
    """Return a uniform whole number between a random fault's bounds; 0 for other modes."""
    if injection.mode != RANDOM:
        return 0.0
    low = math.ceil(injection.a)
    n = math.floor(injection.b) - low + 1
    return float(low + choice(max(n, 1), seed, tick, injection.target, purpose))


@kernel
def misplace(ci: State, injection: InjectionState) -> bool:
    """Move a robot or an obstacle on the server's map; return whether it changed.

    Notes
    -----
    A random place is uniform in the mission disc: radius × √u along a direction of the table.
    """
    x = injection.a
    y = injection.b
    z = injection.c
    mission = ci.mission
    is_robot = injection.affected == POSITION
    if injection.mode == RANDOM:
        radius = PURPOSE_POSITION_RADIUS if is_robot else PURPOSE_OBSTACLE_RADIUS
        angle = PURPOSE_POSITION_ANGLE if is_robot else PURPOSE_OBSTACLE_ANGLE
        target = injection.target
        drawn = choice(N_DIRECTIONS, mission.seed, mission.tick, target, angle)
        direction = ci.directions[drawn]
        reach = mission.radius * math.sqrt(uniform(mission.seed, mission.tick, target, radius))
        x = mission.x + reach * direction.x
        y = mission.y + reach * direction.y
        z = ci.robots[target].z if is_robot else 0.0
    if is_robot:
        return believe(ci, POSITION, injection.target, x, y, z)
    ci.map.is_wrong = 1
    obstacle = ci.obstacles[injection.target]
    obstacle.x = x
    obstacle.y = y
    return x != obstacle.model_x or y != obstacle.model_y


@kernel
def issue(ci: State, orders: Orders | State, plan: Plan, tick: int) -> None:
    """Write the commands that the simulation obeys at a tick: the CI's, or forged ones.

    Parameters
    ----------
    ci
        Local state with the collective intelligence's own commands, which stay as they are.
    orders
        Receives the commands.
    plan
        Faults of this run. Forged commands beat all others.
    tick
        The tick whose motion obeys; forged commands act from the motion of their ``start`` to
        that of their ``finish``.
    """
    for index in range(len(ci.commands)):
        own = ci.commands[index]
        order = orders.commands[index]
        order.heading_x = own.heading_x
        order.heading_y = own.heading_y
        order.speed = own.speed
    for index in range(len(ci.switches)):
        orders.switches[index].active = ci.switches[index].active
    if tick >= ci.mission.duration:
        return
    for injection in plan.commands:
        if injection.start > tick:
            break
        if tick <= injection.finish:
            forge(ci, orders, plan, injection, tick)


@kernel
def forge(
    ci: State, orders: Orders | State, plan: Plan, injection: InjectionState, tick: int
) -> None:
    """Replace one command by the forged one of an active fault."""
    target = injection.target
    if injection.affected == ACTIVATION:
        active = 1 if injection.mode == ACTIVATE else 0
        note(plan, injection, tick, ci.switches[target].active != active)
        orders.switches[target].active = active
    else:
        speed = ci.robots[target].nominal_speed if injection.mode == START else 0.0
        note(plan, injection, tick, ci.commands[target].speed != speed)
        orders.commands[target].speed = speed
