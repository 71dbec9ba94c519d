"""How messages become the collective intelligence's belief: delivered, delayed or blocked.

References
----------
Source paper, sections III-F and III-G (``updateSystemState``).
"""

from mrsfi_runtime.kernel.compiling import kernel
from mrsfi_runtime.kernel.injections import (
    COUNT,
    DELAY,
    ENERGY,
    POSITION,
    SPEED,
    InjectionState,
    Plan,
)
from mrsfi_runtime.kernel.motion import reports_position
from mrsfi_runtime.kernel.state import State


@kernel
def send(world: State, inbox: State) -> None:
    """Bring the newest message of every topic up to the true state of the tick.

    It stands for the generated simulation, bus and interface where there is no bus.
    """
    for index in range(len(world.robots)):
        robot = world.robots[index]
        sent = inbox.robots[index]
        if reports_position(world, index):
            sent.x = robot.x
            sent.y = robot.y
            sent.z = robot.z
        sent.speed = robot.speed
        sent.energy = robot.energy
    for index in range(len(world.sensors)):
        inbox.sensors[index].count = world.sensors[index].count
        inbox.sensors[index].active = world.sensors[index].active


@kernel
def deliver(ci: State, inbox: State, plan: Plan) -> None:
    """Copy this tick's messages into the local state; held-back ones leave it as it was.

    Parameters
    ----------
    ci
        Local state; its ``mission.tick`` is the tick being delivered.
    inbox
        The newest message of every topic.
    plan
        Faults of this run. Delayed properties arrive late and in order; what is still under
        way when the window ends is dropped. Blocked ones are lost.

    Notes
    -----
    What travels in no message (the map, sampling rates and costs) is set back to what the
    model says, so that no effect outlives its window.
    """
    remember(ci, plan)
    for index in range(len(ci.robots)):
        robot = ci.robots[index]
        sent = inbox.robots[index]
        robot.x = sent.x
        robot.y = sent.y
        robot.z = sent.z
        robot.speed = sent.speed
        robot.energy = sent.energy
    for index in range(len(ci.sensors)):
        sensor = ci.sensors[index]
        sample = inbox.sensors[index]
        sensor.count = sample.count
        sensor.active = sample.active
        sensor.rate = sensor.nominal_rate
        sensor.cost = sensor.nominal_cost
    for obstacle in ci.obstacles:
        obstacle.x = obstacle.model_x
        obstacle.y = obstacle.model_y
    ci.map.is_wrong = 0
    withhold(ci, plan)


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
    """Replace what was just delivered by what a delay lets through, or by what was kept."""
    a = injection.kept_a
    b = injection.kept_b
    c = injection.kept_c
    if injection.mode == DELAY and injection.n_held > 0:
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
    note(
        plan, injection, ci.mission.tick, believe(ci, injection.affected, injection.target, a, b, c)
    )


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
    changed = ci.sensors[target].count != int(a)
    ci.sensors[target].count = int(a)
    return changed


@kernel
def note(plan: Plan, injection: InjectionState, tick: int, changed: bool) -> None:
    """Count a tick at which a fault was active, and one at which it changed something."""
    tally = plan.tallies[injection.fault]
    if tally.last_applied != tick:
        tally.last_applied = tick
        tally.applied += 1
    if changed and tally.last_changed != tick:
        tally.last_changed = tick
        tally.changed += 1
