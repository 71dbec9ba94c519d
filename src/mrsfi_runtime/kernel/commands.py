"""Commands, and the robot motion that executes them.

Each robot has one command per channel: heading, speed, and each sensor. Goals react in model
order, and the first goal to claim a channel in a tick keeps it. ``move`` simulates one tick of
the world: motion, energy and sampling.

References
----------
Source paper, sections III-F, III-G and III-H.
"""

import math
from collections.abc import Sequence

from mrsfi_runtime.kernel.geometry import scattered
from mrsfi_runtime.kernel.randomness import PURPOSE_NOISE
from mrsfi_runtime.kernel.state import TOLERANCE, RobotState, State, TraitState, excess, kernel


@kernel
def feasible(robot: RobotState, speed: float) -> float:
    """Return the feasible speed nearest to ``speed``: from 0 to the robot's maximum."""
    return min(max(speed, 0.0), robot.max_speed)


@kernel
def turned(trait: TraitState, x: float, y: float, to_x: float, to_y: float) -> tuple[float, float]:
    """Return the heading nearest to (to_x, to_y) that a robot can reach from (x, y) in a tick.

    If the target is straight behind, to within ``TOLERANCE``, the robot turns to the left.
    """
    aside = x * to_y - y * to_x
    ahead = x * to_x + y * to_y
    if trait.turn_y == 0.0 or abs(aside) * trait.turn_x <= ahead * trait.turn_y:
        return to_x, to_y
    sin = -trait.turn_y if aside < TOLERANCE * min(ahead, 0.0) else trait.turn_y
    near_x = x * trait.turn_x - y * sin
    near_y = y * trait.turn_x + x * sin
    length = math.sqrt(near_x * near_x + near_y * near_y)
    return near_x / length, near_y / length


@kernel
def release(ci: State) -> None:
    """Free all channels; called once a tick before the goals react."""
    for command in ci.commands:
        command.heading_claimed = 0
        command.speed_claimed = 0
    for switch in ci.switches:
        switch.claimed = 0


@kernel
def steer(ci: State, index: int, x: float, y: float) -> None:
    """Command the heading of a robot, unless an earlier goal did.

    The first heading that a robot is denied because it evades is kept as its wish.

    Parameters
    ----------
    ci
        Local state.
    index
        Index of the robot.
    x, y
        Direction of any length; one shorter than ``TOLERANCE`` is ignored.
    """
    command, wish = ci.commands[index], ci.wishes[index]
    length = math.sqrt(x * x + y * y)
    if length <= TOLERANCE:
        return
    if command.heading_claimed == 0:
        command.heading_claimed = 1
        command.heading_x, command.heading_y = x / length, y / length
    elif wish.tick == ci.mission.tick and wish.x == 0.0 and wish.y == 0.0:
        wish.x, wish.y = x / length, y / length


@kernel
def set_speed(ci: State, index: int, speed: float) -> None:
    """Command the feasible speed of a robot, unless an earlier goal did."""
    command = ci.commands[index]
    if command.speed_claimed == 0:
        command.speed_claimed = 1
        command.speed = feasible(ci.robots[index], speed)


@kernel
def switch_sensor(ci: State, index: int, active: int) -> None:
    """Switch a sensor on (1) or off (0), unless an earlier goal did."""
    switch = ci.switches[index]
    if switch.claimed == 0:
        switch.claimed = 1
        switch.active = active


@kernel
def move(world: State, valid: Sequence[int], tick: int) -> None:
    """Move every robot by its commanded speed along its heading, spend energy, take samples.

    ``world`` is the true state after the previous tick, with the commands to execute; ``valid`` is
    the number of valid samples of each sensor in this tick, if it is active.

    Notes
    -----
    A robot spends distance × energy per distance unit and, for each active sensor, samples
    per tick × energy per sample. A robot without energy stops, and so do its sensors; in the
    tick in which the energy runs out it still moves. No robot exceeds its maximum speed.
    """
    world.mission.tick = tick
    for index in range(len(world.robots)):
        robot, wake = world.robots[index], world.wakes[index]
        wake.x, wake.y, wake.reach = robot.x, robot.y, math.inf
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
    """Return the position that a robot reports, with the noise of this tick."""
    robot = world.robots[index]
    noise = world.traits[index].position_noise
    if noise <= 0.0:
        return robot.x, robot.y
    return scattered(world, robot.x, robot.y, noise, index, PURPOSE_NOISE)
