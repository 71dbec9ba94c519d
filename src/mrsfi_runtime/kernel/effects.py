"""Delivery of messages to the local state, and the effects of active faults on it and on commands.

In each tick ``deliver`` copies received messages into the local state and holds back delayed or
blocked ones. ``falsify`` then applies faults of built-in modes to the local state, and ``disturb``
user-defined fault types, by a region of the generated code. ``issue`` forges commands; the
collective intelligence's own commands apply again later. ``arm`` detects the events that trigger
faults, in the true state, each once in a flight.

Invariant: effects read the true value of the tick, so nothing accumulates and nothing has to be
undone. At ``finish + 1`` the next delivery restores the property. ``note`` counts the ticks at
which a fault was active, and those at which it changed a value.

Begin with ``deliver``, then ``falsify`` and ``issue``.

References
----------
Source paper, sections III-B b), III-F and III-G (``updateSystemState``, ``executeFaults``).
"""

import math
from dataclasses import dataclass
from typing import TypeAlias

from mrsfi_runtime.kernel.commands import feasible, reported_place, reports_position, turned
from mrsfi_runtime.kernel.geometry import in_area, scattered
from mrsfi_runtime.kernel.goal_tasks.table import is_reached
from mrsfi_runtime.kernel.injections import (
    ACTIVATION,
    COST,
    COUNT,
    ENERGY,
    OBSTACLE,
    OF_OBSTACLE,
    OF_SENSOR,
    POSITION,
    SPEED,
    InjectionState,
    OwnEffect,
    OwnFault,
    Plan,
    TriggerState,
    WaitingState,
)
from mrsfi_runtime.kernel.randomness import choice, uniform
from mrsfi_runtime.kernel.state import CommandState, State, SwitchState, kernel
from mrsfi_runtime.model.faults import Event

Belief: TypeAlias = tuple[float, float, float]
"""Believed value of a property: a position, or one number and zeros."""

PURPOSES = (8, 6, 4, 12, 7, 5, 10)  # position, speed, energy, count, rate, cost, obstacle
"""Purpose under which a random value of each property is drawn, by the number of its ``Field``.

For a position it draws the distance from the centre; ``purpose + 1`` draws the direction.
"""


@kernel
def falsify(ci: State, plan: Plan) -> None:
    """Apply every active fault of a built-in mode that changes a value of the local state.

    The value just delivered is the true one, because conflicting faults are never active at once.
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
    """Return the falsified value of a true number.

    Random values are uniform between the fault's bounds; they are whole, except energies and costs.
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
    """Return the falsified position of a robot or an obstacle.

    A random position is anywhere in the mission disc, at height ``z``.
    """
    if injection.is_random == 0:
        return injection.a, injection.b, injection.c
    mission = ci.mission
    purpose = PURPOSES[injection.affected]
    x, y = scattered(ci, mission.x, mission.y, mission.radius, injection.target, purpose)
    return x, y, z


@kernel
def believed(ci: State, injection: InjectionState) -> Belief:
    """Return the believed value of an injection's property."""
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
    """Set the believed value of an injection's property, and count whether it changed."""
    target, tick = injection.target, ci.mission.tick
    a, b, _ = value
    if injection.affected == POSITION:
        ci.map.displaced = tick + 1
        robot = ci.robots[target]
        robot.x, robot.y, robot.z = value
    elif injection.affected == OBSTACLE:
        ci.map.is_wrong = 1
        ci.obstacles[target].x, ci.obstacles[target].y = a, b
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
    if injection.affected != POSITION:
        ci.map.misled = tick + 1
    note(plan, injection, tick, a != before[0] or b != before[1])


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


@dataclass(slots=True)
class Orders:
    """The commands sent to the simulation: one per robot, and one switch per sensor."""

    commands: list[CommandState]
    switches: list[SwitchState]


@kernel
def issue(ci: State, orders: Orders | State, plan: Plan, tick: int) -> None:
    """Write the commands that the simulation executes at a tick: the CI's, or forged ones.

    The heading sent is one that the robot can turn to from its last one, the speed a feasible one.
    ``ci`` keeps the sent speed, because speed control needs it. The CI's own commands stay as they
    are. Forged commands override all others, from the motion of their ``start`` to that of their
    ``finish``.
    """
    for index in range(len(ci.commands)):
        own = ci.commands[index]
        order = orders.commands[index]
        order.heading_x, order.heading_y = turned(
            ci.traits[index], order.heading_x, order.heading_y, own.heading_x, own.heading_y
        )
        order.speed = feasible(ci.robots[index], own.speed)
        own.sent_speed = order.speed
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
        active = int(injection.a)
        note(plan, injection, tick, ci.switches[target].active != active)
        orders.switches[target].active = active
    else:
        robot = ci.robots[target]
        command = ci.commands[target]
        speed = feasible(robot, injection.b * robot.nominal_speed)
        note(plan, injection, tick, command.sent_speed != speed)
        command.sent_speed = speed
        orders.commands[target].speed = speed


@kernel
def disturb(apply: OwnEffect, ci: State, inbox: State, plan: Plan) -> None:
    """Apply every active fault of a user-defined type, by start, then in specification order.

    All other effects are already applied to ``ci``; ``inbox`` has the newest message of each topic.
    """
    tick = ci.mission.tick
    for fault in plan.own:
        if fault.start > tick:
            break
        if tick <= fault.finish:
            fault.age = tick - fault.start
            if fault.kind == OF_OBSTACLE:
                ci.map.is_wrong = 1
            before = touchable(ci, fault)
            apply(ci, inbox, fault)
            note(plan, fault, tick, touchable(ci, fault) != before)


@kernel
def touchable(ci: State, fault: OwnFault) -> tuple[float, float, float, float]:
    """Return all that a fault could change of its target."""
    if fault.kind == OF_OBSTACLE:
        obstacle = ci.obstacles[fault.target]
        return obstacle.x, obstacle.y, 0.0, 0.0
    if fault.kind == OF_SENSOR:
        sensor = ci.sensors[fault.target]
        return float(sensor.count), sensor.rate, sensor.cost, 0.0
    robot = ci.robots[fault.target]
    return robot.x, robot.y, robot.speed, robot.energy


VIOLATED, REACHED, ENTERED, EFFECT = map(int, Event)


@kernel
def arm(world: State, plan: Plan, violated: list[int], tick: int) -> None:
    """Record the events of a tick, and activate the faults that are due at the next one.

    ``violated`` flags the goals violated in truth. An activated fault gets its new window in place:
    the lists stay sorted as far as they are read, since no start lies beyond the tick that is read.
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
    """Return whether a trigger's event happens in the present state."""
    if trigger.event == VIOLATED:
        return violated[trigger.of] == 1
    if trigger.event == REACHED:
        return is_reached(world, trigger.of)
    if trigger.event == ENTERED:
        robot = world.robots[trigger.of]
        return in_area(world, trigger, robot.x, robot.y)
    for source in range(trigger.first_source, trigger.first_source + trigger.n_sources):
        if plan.tallies[plan.sources[source]].changed > 0:
            return True
    return False


@kernel
def begin(plan: Plan, waiting: WaitingState, start: int, finish: int) -> None:
    """Set the window of a triggered injection."""
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


@kernel
def send(world: State, inbox: State) -> None:
    """Bring the newest message of every topic up to the true state of the tick.

    It replaces the generated simulation, bus and interface in flights without a bus.
    """
    for index in range(len(world.robots)):
        robot = world.robots[index]
        sent = inbox.robots[index]
        if reports_position(world, index):
            sent.x, sent.y = reported_place(world, index)
            sent.z = robot.z
        else:
            inbox.map.displaced = world.mission.tick + 1
        sent.speed = robot.speed
        sent.energy = robot.energy
    for index in range(len(world.sensors)):
        inbox.sensors[index].count = world.sensors[index].count
        inbox.sensors[index].active = world.sensors[index].active


@kernel
def deliver(ci: State, inbox: State, plan: Plan) -> None:
    """Copy this tick's messages into the local state, except those held back.

    ``ci.mission.tick`` is the tick being delivered, ``inbox`` has the newest message of every
    topic. Delayed properties arrive late and in order; those still under way when the window
    ends are dropped. Blocked ones are lost. Properties without messages (the map, sampling rates
    and costs) are reset to the model's values, so that no effect outlives its window.
    """
    remember(ci, plan)
    ci.map.displaced = max(ci.map.displaced, inbox.map.displaced)
    for index in range(len(ci.robots)):
        robot, wake = ci.robots[index], ci.wakes[index]
        sent = inbox.robots[index]
        wake.x, wake.y = robot.x, robot.y
        robot.x, robot.y, robot.z = sent.x, sent.y, sent.z
        robot.speed = sent.speed
        robot.energy = sent.energy
    for index in range(len(ci.sensors)):
        sensor = ci.sensors[index]
        sample = inbox.sensors[index]
        sensor.count = sample.count
        sensor.active = sample.active
        sensor.rate = sensor.nominal_rate
        sensor.cost = sensor.nominal_cost
    if ci.map.is_wrong + ci.map.was_wrong > 0:
        for k in range(len(ci.obstacles)):
            wake, obstacle = ci.wakes[len(ci.robots) + k], ci.obstacles[k]
            wake.x, wake.y = obstacle.x, obstacle.y
            obstacle.x, obstacle.y = obstacle.model_x, obstacle.model_y
    ci.map.was_wrong = ci.map.is_wrong
    ci.map.is_wrong = 0
    withhold(ci, plan)


@kernel
def remember(ci: State, plan: Plan) -> None:
    """Store the believed value of every property whose messages are now held back."""
    tick = ci.mission.tick
    for injection in plan.messages:
        if injection.start > tick:
            break
        if tick <= injection.finish:
            injection.kept_a, injection.kept_b, injection.kept_c = believed(ci, injection)


@kernel
def withhold(ci: State, plan: Plan) -> None:
    """Undo the delivery of every property whose messages are now held back.

    A delayed value enters the delay queue; a value that leaves the queue becomes the belief.
    """
    tick = ci.mission.tick
    held = plan.held
    for injection in plan.messages:
        if injection.start > tick:
            break
        if tick <= injection.finish:
            delivered = believed(ci, injection)
            value = injection.kept_a, injection.kept_b, injection.kept_c
            if injection.n_held > 0:
                age = tick - injection.start
                slot = injection.first_held + 3 * (age % injection.n_held)
                if age >= injection.n_held:
                    value = held[slot], held[slot + 1], held[slot + 2]
                held[slot], held[slot + 1], held[slot + 2] = delivered
            believe(ci, plan, injection, delivered, value)
