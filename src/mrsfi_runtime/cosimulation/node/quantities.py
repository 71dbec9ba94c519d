"""What a node can be told of a belief, and what it can command, by the names of a mapping."""

import math
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple, TypeAlias

from mrsfi_runtime.kernel.commands import feasible
from mrsfi_runtime.kernel.state import TOLERANCE, State
from mrsfi_runtime.model.fault_types import Field

Read: TypeAlias = Callable[[State, int], Any]
"""Returns something of a belief, of an element by its index."""


class Quantity(NamedTuple):
    """Something that a node can be told; ``affected`` is what faults make of it, if they do."""

    read: Read
    affected: Field | None = None


def _heading(x: Callable[[float, float, float], Any]) -> Quantity:
    """Return something of the heading and the speed that are believed."""

    def read(ci: State, index: int) -> Any:
        command = ci.commands[index]
        return x(command.heading_x, command.heading_y, ci.robots[index].speed)

    return Quantity(read)


QUANTITIES: Mapping[str, Mapping[str, Quantity]] = {
    "robot": {
        "x": Quantity(lambda ci, index: ci.robots[index].x, Field.POSITION),
        "y": Quantity(lambda ci, index: ci.robots[index].y, Field.POSITION),
        "z": Quantity(lambda ci, index: ci.robots[index].z, Field.POSITION),
        "speed": Quantity(lambda ci, index: ci.robots[index].speed, Field.SPEED),
        "vx": _heading(lambda x, _, speed: x * speed)._replace(affected=Field.SPEED),
        "vy": _heading(lambda _, y, speed: y * speed)._replace(affected=Field.SPEED),
        "energy": Quantity(lambda ci, index: ci.robots[index].energy, Field.ENERGY),
        "heading_x": _heading(lambda x, _, __: x),
        "heading_y": _heading(lambda _, y, __: y),
        "yaw": _heading(lambda x, y, _: math.atan2(y, x)),
        "qz": _heading(lambda x, y, _: math.sin(math.atan2(y, x) / 2.0)),
        "qw": _heading(lambda x, y, _: math.cos(math.atan2(y, x) / 2.0)),
        "sent": Quantity(lambda ci, index: ci.commands[index].sent_speed),
    },
    "sensor": {
        "samples": Quantity(lambda ci, index: ci.sensors[index].count, Field.COUNT),
        "active": Quantity(lambda ci, index: ci.sensors[index].active == 1),
        "rate": Quantity(lambda ci, index: ci.sensors[index].rate, Field.RATE),
        "cost": Quantity(lambda ci, index: ci.sensors[index].cost, Field.COST),
    },
    "obstacle": {
        "x": Quantity(lambda ci, index: ci.obstacles[index].x, Field.OBSTACLE),
        "y": Quantity(lambda ci, index: ci.obstacles[index].y, Field.OBSTACLE),
        "radius": Quantity(lambda ci, index: ci.obstacles[index].radius),
    },
}
"""By kind of element and name. A heading is that which the robot was told, as it obeys at once;
``yaw`` is its angle, ``qz`` and ``qw`` its quaternion, ``sent`` the speed that it was told, forged
ones too."""

SPOKEN = (Field.POSITION, Field.SPEED, Field.ENERGY, Field.COUNT)
"""Properties of which a world speaks in every tick; a position only while the robot knows it."""

Given: TypeAlias = Mapping[str, float]
"""What a message commands, by name."""

COMMANDS: Mapping[str, Mapping[str, str]] = {
    "robot": {
        "heading_x": "direction of any length, first coordinate",
        "heading_y": "second coordinate",
        "yaw": "direction as an angle in radians, from x to y",
        "turn": "change of the direction in radians",
        "vx": "velocity in units per tick, first coordinate",
        "vy": "second coordinate",
        "to_x": "point to head for, first coordinate",
        "to_y": "second coordinate",
        "speed": "units per tick",
    },
    "sensor": {"active": "whether it is on"},
}
"""What a node can command, by kind of element."""

PAIRS = (("heading_x", "heading_y"), ("vx", "vy"), ("to_x", "to_y"))
"""Commands that make sense together only."""


def command_robot(ci: State, index: int, given: Given) -> None:
    """Have a robot of a belief commanded; what a message says replaces what came before."""
    robot, command = ci.robots[index], ci.commands[index]
    if "heading_x" in given:
        _turn(ci, index, given["heading_x"], given["heading_y"])
    if "to_x" in given:
        _turn(ci, index, given["to_x"] - robot.x, given["to_y"] - robot.y)
    if "yaw" in given:
        _turn(ci, index, math.cos(given["yaw"]), math.sin(given["yaw"]))
    if "turn" in given:
        x, y = command.heading_x, command.heading_y
        cos, sin = math.cos(given["turn"]), math.sin(given["turn"])
        _turn(ci, index, x * cos - y * sin, x * sin + y * cos)
    speed = given.get("speed")
    if "vx" in given:
        speed = math.sqrt(given["vx"] ** 2 + given["vy"] ** 2)
        _turn(ci, index, given["vx"], given["vy"])
    if speed is not None:
        command.speed_claimed = 1
        command.speed = feasible(robot, speed)


def command_sensor(ci: State, index: int, given: Given) -> None:
    """Have a sensor of a belief switched."""
    switch = ci.switches[index]
    switch.claimed = 1
    switch.active = int(given["active"] != 0)


def _turn(ci: State, index: int, x: float, y: float) -> None:
    """Command a heading; one that is hardly any is ignored, and a unit vector stays as it is."""
    command = ci.commands[index]
    length = math.sqrt(x * x + y * y)
    if length <= TOLERANCE:
        return
    if abs(length - 1.0) > TOLERANCE:
        x, y = x / length, y / length
    command.heading_claimed = 1
    command.heading_x, command.heading_y = x, y
