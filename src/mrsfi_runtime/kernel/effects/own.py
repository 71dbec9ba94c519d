"""What fault types of a team's own do: a region of the generated code, called once a tick."""

from mrsfi_runtime.kernel.compiling import kernel
from mrsfi_runtime.kernel.effects.belief import note
from mrsfi_runtime.kernel.injections import OF_OBSTACLE, OF_SENSOR, OwnEffect, OwnFault, Plan
from mrsfi_runtime.kernel.state import State


@kernel
def disturb(apply: OwnEffect, ci: State, inbox: State, plan: Plan) -> None:
    """Apply every active fault of a team's own type, by start, then as the specification has them.

    All other effects have been applied to ``ci``; ``inbox`` has the newest message of every topic.
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
