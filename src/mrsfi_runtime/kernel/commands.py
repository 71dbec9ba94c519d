"""How a collective intelligence commands its robots: one command per robot and channel.

Channels are the heading, the speed and each sensor. Goals react in model order, and the
first to claim a channel in a tick keeps it.

References
----------
Source paper, section III-G.
"""

import math

from mrsfi_runtime.kernel.compiling import kernel
from mrsfi_runtime.kernel.state import RobotState, State, TraitState
from mrsfi_runtime.kernel.tolerance import TOLERANCE


@kernel
def feasible(robot: RobotState, speed: float) -> float:
    """Return the speed nearest to a wanted one that a robot can fly: from 0 to its maximum."""
    return min(max(speed, 0.0), robot.max_speed)


@kernel
def turned(trait: TraitState, x: float, y: float, to_x: float, to_y: float) -> tuple[float, float]:
    """Return the heading nearest to a wanted one that a robot can turn to from (x, y) in a tick.

    Where the wanted one is straight behind, to within ``TOLERANCE``, it turns to the left.
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
    """Command the heading of a robot, unless an earlier goal has.

    Parameters
    ----------
    ci
        Local state.
    index
        Index of the robot.
    x, y
        Direction of any length; one shorter than ``TOLERANCE`` is ignored.
    """
    command = ci.commands[index]
    length = math.sqrt(x * x + y * y)
    if command.heading_claimed == 0 and length > TOLERANCE:
        command.heading_claimed = 1
        command.heading_x = x / length
        command.heading_y = y / length


@kernel
def set_speed(ci: State, index: int, speed: float) -> None:
    """Command the speed of a robot, as far as it can fly it, unless an earlier goal has."""
    command = ci.commands[index]
    if command.speed_claimed == 0:
        command.speed_claimed = 1
        command.speed = feasible(ci.robots[index], speed)


@kernel
def switch_sensor(ci: State, index: int, active: int) -> None:
    """Switch a sensor on (1) or off (0), unless an earlier goal has spoken for it."""
    switch = ci.switches[index]
    if switch.claimed == 0:
        switch.claimed = 1
        switch.active = active
