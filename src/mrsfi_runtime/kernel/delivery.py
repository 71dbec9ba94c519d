"""How messages become the collective intelligence's belief: delivered, delayed or blocked.

References
----------
Source paper, sections III-F and III-G (``updateSystemState``).
"""

from mrsfi_runtime.kernel.compiling import kernel
from mrsfi_runtime.kernel.effects.belief import believe, believed
from mrsfi_runtime.kernel.injections import Plan
from mrsfi_runtime.kernel.motion import reported_place, reports_position
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
            sent.x, sent.y = reported_place(world, index)
            sent.z = robot.z
        sent.speed = robot.speed
        sent.energy = robot.energy
    for index in range(len(world.sensors)):
        inbox.sensors[index].count = world.sensors[index].count
        inbox.sensors[index].active = world.sensors[index].active


@kernel
def deliver(ci: State, inbox: State, plan: Plan) -> None:
    """Copy this tick's messages into the local state; held-back ones leave it as it was.

    ``ci.mission.tick`` is the tick being delivered, ``inbox`` has the newest message of every
    topic. Delayed properties arrive late and in order; what is still under way when the window
    ends is dropped. Blocked ones are lost. What travels in no message (the map, sampling rates
    and costs) is set back to what the model says, so that no effect outlives its window.
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
            injection.kept_a, injection.kept_b, injection.kept_c = believed(ci, injection)


@kernel
def withhold(ci: State, plan: Plan) -> None:
    """Take back what was just delivered of every property whose messages are held back now.

    What is delayed goes under way, and what arrives after its delay is believed.
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
