"""What the simulated world does in one tick: motion, energy and sampling.

References
----------
Source paper, sections III-F and III-H.
"""

from collections.abc import Sequence

from mrsfi_runtime.kernel.commands import feasible
from mrsfi_runtime.kernel.compiling import kernel
from mrsfi_runtime.kernel.geometry import scattered
from mrsfi_runtime.kernel.randomness import PURPOSE_NOISE
from mrsfi_runtime.kernel.state import State
from mrsfi_runtime.kernel.tolerance import excess


@kernel
def move(world: State, valid: Sequence[int], tick: int) -> None:
    """Move every robot by its commanded speed along its heading, spend energy, take samples.

    ``world`` is the true state after the tick before, whose commands are obeyed; ``valid`` says
    how many samples of each sensor are valid in this tick, if it is active.

    Notes
    -----
    A robot spends distance × energy per distance unit and, for each active sensor, samples
    per tick × energy per sample. One without energy stops, its sensors with it; in the tick
    in which the energy runs out it still moves. No robot flies faster than it can.
    """
    world.mission.tick = tick
    for index in range(len(world.robots)):
        robot = world.robots[index]
        if robot.energy <= 0.0:
            robot.speed = 0.0
            for k in range(robot.first_sensor, robot.first_sensor + robot.n_sensors):
                world.sensors[k].active = 0
            continue
        command = world.commands[index]
        speed = feasible(robot, command.speed)
        robot.x += command.heading_x * speed
        robot.y += command.heading_y * speed
        robot.speed = speed
        spent = speed * robot.energy_per_distance
        for k in range(robot.first_sensor, robot.first_sensor + robot.n_sensors):
            sensor = world.sensors[k]
            sensor.active = world.switches[k].active
            if sensor.active:
                spent += sensor.nominal_rate * sensor.nominal_cost
                sensor.count += valid[k]
        robot.energy = max(excess(robot.energy, spent), 0.0)


@kernel
def reports_position(world: State, index: int) -> bool:
    """Return whether a robot publishes its position: not while its GPS sensor is off."""
    gps = world.robots[index].gps
    return gps < 0 or world.sensors[gps].active == 1


@kernel
def reported_place(world: State, index: int) -> tuple[float, float]:
    """Return where a robot says that it is: as far off as its noise has it in this tick."""
    robot = world.robots[index]
    noise = world.traits[index].position_noise
    if noise <= 0.0:
        return robot.x, robot.y
    return scattered(world, robot.x, robot.y, noise, index, PURPOSE_NOISE)
