"""How a collective intelligence commands its robots: one command per robot and channel.

Channels are the heading, the speed and each sensor. Goals react in model order, and the
first to claim a channel in a tick keeps it.

References
----------
Source paper, section III-G.
"""

import math

from mrsfi_runtime.kernel.compiling import kernel
from mrsfi_runtime.kernel.state import State

SPEED_LIMIT = 5.0
"""Greatest speed that may be commanded, as a multiple of the nominal speed."""


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
    """Command the heading of a robot, unless an earlier goal has; a zero vector is ignored.

    Parameters
    ----------
    ci
        Local state.
    index
        Index of the robot.
    x, y
        Direction of any length.
    """
    command = ci.commands[index]
    length = math.sqrt(x * x + y * y)
    if command.heading_claimed == 0 and length > 0.0:
        command.heading_claimed = 1
        command.heading_x = x / length
        command.heading_y = y / length


@kernel
def set_speed(ci: State, index: int, speed: float) -> None:
    """Command the speed of a robot, within 0 and ``SPEED_LIMIT`` × nominal, unless claimed."""
    command = ci.commands[index]
    if command.speed_claimed == 0:
        command.speed_claimed = 1
        limit = SPEED_LIMIT * ci.robots[index].nominal_speed
        command.speed = min(max(speed, 0.0), limit)


@kernel
def switch_sensor(ci: State, index: int, active: int) -> None:
    """Switch a sensor on (1) or off (0), unless an earlier goal has spoken for it."""
    switch = ci.switches[index]
    if switch.claimed == 0:
        switch.claimed = 1
        switch.active = active
