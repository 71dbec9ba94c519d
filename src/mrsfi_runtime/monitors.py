"""Monitors: checks of what the CI receives, written once for recorded flights and for regions.

The function of a monitor returns a measure of an element, by its index, in a belief: how far a
report is from what command, map and data sheet lead to expect. It reads ``ci.robots``,
``ci.sensors`` and ``ci.obstacles`` of this tick, ``ci.commands`` and ``ci.switches`` of the tick
before, and ``ci.heard``, the reports of the tick before: of each robot, sensor and obstacle. At the
first tick these are the model's values. If the unit is ticks, the function returns whether
something is so that should not last; the measure is for how many ticks in a row it is.

``causes.monitors`` calls the same function with a recorded flight, whose values are arrays over all
ticks. So it uses arithmetic, comparisons, ``&`` and ``|``, ``abs min max math.sqrt``, other such
functions, and loops over indices; it has no ``if`` on a value that changes.

Begin with ``MONITORS``. A project's own, in its ``monitors.py``, are of the same kind.
"""

from collections.abc import Callable
from typing import NamedTuple

from mrsfi_runtime.kernel.commands import feasible
from mrsfi_runtime.kernel.geometry import distance
from mrsfi_runtime.kernel.state import HeardState, State, kernel
from mrsfi_runtime.model.fault_types import Range


@kernel
def moved(ci: State, r: int) -> float:
    """Return the distance between a robot's last two positions."""
    robot, was = ci.robots[r], ci.heard[r]
    return distance(was.x, was.y, robot.x, robot.y)


@kernel
def ordered(ci: State, r: int) -> float:
    """Return the speed that a robot's last command asks for; 0 if it had no energy."""
    return feasible(ci.robots[r], ci.commands[r].speed) * (ci.heard[r].energy > 0.0)


@kernel
def frozen(ci: State, r: int) -> bool:
    """Return whether a robot's position stays the same, although its command is to move."""
    return (moved(ci, r) == 0.0) & (ordered(ci, r) > 0.0)


@kernel
def silent(ci: State, r: int) -> bool:
    """Return whether all that a robot reports stays the same, although its command is to move."""
    robot, was = ci.robots[r], ci.heard[r]
    is_same = (robot.z == was.z) & (robot.speed == was.speed) & (robot.energy == was.energy)
    return frozen(ci, r) & is_same


@kernel
def outside(ci: State, r: int) -> float:
    """Return the distance of a robot from the disc of the mission area, 0 inside."""
    robot, area = ci.robots[r], ci.mission
    return max(distance(area.x, area.y, robot.x, robot.y) - area.radius, 0.0)


@kernel
def off_course(ci: State, r: int) -> float:
    """Return the distance of a robot from where its last command should have taken it."""
    robot, was, command, speed = ci.robots[r], ci.heard[r], ci.commands[r], ordered(ci, r)
    x, y = was.x + speed * command.heading_x, was.y + speed * command.heading_y
    return distance(x, y, robot.x, robot.y)


@kernel
def off_speed(ci: State, r: int) -> float:
    """Return the difference between a robot's speed and its last command."""
    return abs(ci.robots[r].speed - ordered(ci, r))


@kernel
def off_distance(ci: State, r: int) -> float:
    """Return the difference between a robot's speed and the distance of its last positions."""
    return abs(ci.robots[r].speed - moved(ci, r))


@kernel
def left(ci: State, r: int) -> float:
    """Return the energy that speed and active sensors leave a robot of that of a tick ago."""
    robot, before = ci.robots[r], ci.heard[r].energy
    spent = robot.speed * robot.energy_per_distance
    for s in range(robot.first_sensor, robot.first_sensor + robot.n_sensors):
        sensor = ci.sensors[s]
        spent = spent + sensor.active * sensor.nominal_rate * sensor.nominal_cost
    return max(before - spent * (before > 0.0), 0.0)


@kernel
def imbalance(ci: State, r: int) -> float:
    """Return the difference between a robot's energy and what should be left."""
    return abs(ci.robots[r].energy - left(ci, r))


@kernel
def disobeying(ci: State, s: int) -> bool:
    """Return whether a sensor is not switched as commanded, although its robot had energy."""
    sensor = ci.sensors[s]
    return (sensor.active != ci.switches[s].active) & (ci.heard[sensor.robot].energy > 0.0)


@kernel
def sampled(ci: State, s: int) -> float:
    """Return by how much the count of a sensor changes."""
    return abs(ci.sensors[s].count - ci.heard[len(ci.robots) + s].count)


@kernel
def idle(ci: State, s: int) -> bool:
    """Return whether an active sensor has no new samples."""
    return (sampled(ci, s) == 0.0) & (ci.sensors[s].active == 1)


@kernel
def off_sheet(ci: State, s: int) -> float:
    """Return the difference of a sensor's rate, and of its cost per sample, from the model."""
    sensor = ci.sensors[s]
    return distance(sensor.nominal_rate, sensor.nominal_cost, sensor.rate, sensor.cost)


@kernel
def off_map(ci: State, o: int) -> float:
    """Return the distance of an obstacle from its position in the model."""
    rock = ci.obstacles[o]
    return distance(rock.model_x, rock.model_y, rock.x, rock.y)


@kernel
def lasting(heard: HeardState, k: int, is_so: bool) -> float:
    """Return for how many ticks in a row something is so; ``k`` numbers what a region counts."""
    heard.in_a_row[k] = (heard.in_a_row[k] + 1.0) * is_so
    return heard.in_a_row[k]


@kernel
def remember(ci: State) -> None:
    """Keep the reports of this tick for the next one; called after all monitors."""
    for r in range(len(ci.robots)):
        robot, was = ci.robots[r], ci.heard[r]
        was.x, was.y, was.z = robot.x, robot.y, robot.z
        was.speed, was.energy = robot.speed, robot.energy
    for s in range(len(ci.sensors)):
        ci.heard[len(ci.robots) + s].count = ci.sensors[s].count
    for o in range(len(ci.obstacles)):
        was = ci.heard[len(ci.robots) + len(ci.sensors) + o]
        was.x, was.y = ci.obstacles[o].x, ci.obstacles[o].y


@kernel
def alarmed(heard: HeardState) -> bool:
    """Return whether an alarm lasts, for one tick less from now on."""
    if heard.alarm > 0:
        heard.alarm -= 1
        return True
    return False


class Monitor(NamedTuple):
    """A check of each of the ``elements``, a list of a state, that raises an alarm above a limit.

    ``unit`` is that of its measure, or ticks if it measures for how many something is so.
    """

    name: str
    elements: str
    unit: Range
    measure: Callable[[State, int], float]


MONITORS = (
    Monitor("position frozen", "robots", Range.TICKS, frozen),
    Monitor("age of reports", "robots", Range.TICKS, silent),
    Monitor("position range", "robots", Range.X, outside),
    Monitor("position rate", "robots", Range.SPEED, moved),
    Monitor("motion against command", "robots", Range.SPEED, off_course),
    Monitor("speed against command", "robots", Range.SPEED, off_speed),
    Monitor("speed against positions", "robots", Range.SPEED, off_distance),
    Monitor("energy balance", "robots", Range.ENERGY, imbalance),
    Monitor("switch against command", "sensors", Range.TICKS, disobeying),
    Monitor("sample count frozen", "sensors", Range.TICKS, idle),
    Monitor("sample count rate", "sensors", Range.COUNT, sampled),
    Monitor("data sheet", "sensors", Range.RATE, off_sheet),
    Monitor("map", "obstacles", Range.X, off_map),
)
"""The built-in monitors; of two that gain the same, the earlier one is recommended."""
