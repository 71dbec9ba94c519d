"""What forged commands do: they beat the collective intelligence's own, which hold again later.

References
----------
Source paper, sections III-B b) and III-G.
"""

from dataclasses import dataclass

from mrsfi_runtime.kernel.commands import feasible, turned
from mrsfi_runtime.kernel.compiling import kernel
from mrsfi_runtime.kernel.effects.belief import note
from mrsfi_runtime.kernel.injections import ACTIVATION, InjectionState, Plan
from mrsfi_runtime.kernel.state import CommandState, State, SwitchState


@dataclass(slots=True)
class Orders:
    """What leaves for the simulation: one command per robot, one switch per sensor."""

    commands: list[CommandState]
    switches: list[SwitchState]


@kernel
def issue(ci: State, orders: Orders | State, plan: Plan, tick: int) -> None:
    """Write the commands that the simulation obeys at a tick: the CI's, or forged ones.

    The heading that leaves is one that the robot can turn to from the last, the speed one that it
    can fly, which ``ci`` remembers: who regulates a speed has to know what the robot was told. The
    CI's own commands stay as they are. Forged ones beat all others, from the motion of their
    ``start`` to that of their ``finish``.
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
