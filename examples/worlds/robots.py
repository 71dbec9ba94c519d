"""Shared by all worlds: robots that obey heading and speed, take samples and spend energy."""

import argparse
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

Place = tuple[float, float, float]
MOVED = ("x", "y", "z", "speed", "distance")


class WorldError(Exception):
    """What a world does not fly: a mission, an option, or a value; its message says all."""


@dataclass(slots=True)
class Sensor:
    """A sensor, and its commanded state (``is_wanted``)."""

    name: str
    samples_per_tick: int
    energy_per_sample: float
    tells_position: bool
    count: int = 0
    is_active: bool = False
    is_wanted: bool = True


@dataclass(slots=True)
class Robot:
    """A robot, its commands and its place; distances in units of the mission.

    Commands are a unit heading in the plane and a distance per tick. At the end of a tick,
    ``position`` and ``speed`` are true. The robot reports ``reported``, at most
    ``position_noise`` away from ``position``.
    """

    name: str
    start: Place
    energy_at_start: float
    energy_per_distance: float
    greatest_speed: float
    sensors: list[Sensor] = field(default_factory=list)
    radius: float = 1.0
    position_noise: float = 0.0
    energy: float = 0.0
    heading: tuple[float, float] = (0.0, 0.0)
    commanded_speed: float = 0.0
    position: Place = (0.0, 0.0, 0.0)
    reported: Place = (0.0, 0.0, 0.0)
    speed: float = 0.0

    @property
    def has_power(self) -> bool:
        """Whether there is energy left to drive and to sample with."""
        return self.energy > 0.0

    @property
    def wanted_speed(self) -> float:
        """The commanded speed within the robot's maximum; 0 without energy."""
        return min(self.commanded_speed, self.greatest_speed) if self.has_power else 0.0

    def reset(self) -> None:
        """Go back to before the first tick."""
        self.energy = self.energy_at_start
        self.heading, self.commanded_speed = (0.0, 0.0), 0.0
        self.position, self.reported, self.speed = self.start, self.start, 0.0
        for sensor in self.sensors:
            sensor.count, sensor.is_active, sensor.is_wanted = 0, False, True


@dataclass(frozen=True, slots=True)
class Wall:
    """A side of a polygon: its middle, its length, and its angle to the x axis in radians."""

    middle: Place
    length: float
    angle: float


@dataclass(frozen=True, slots=True)
class Obstacle:
    """A cylinder that stands upright, or a prism if it has corners: it then has no radius."""

    name: str
    center: Place
    radius: float
    corners: tuple[Place, ...] = ()

    @property
    def walls(self) -> Iterator[Wall]:
        """The sides of a prism, for physics that know no polygons; a cylinder has none."""
        for (x, y, z), (u, v, _) in zip(
            self.corners, (*self.corners[1:], *self.corners[:1]), strict=True
        ):
            middle = (x + u) / 2.0, (y + v) / 2.0, z
            yield Wall(middle, math.hypot(u - x, v - y), math.atan2(v - y, u - x))


@dataclass(frozen=True, slots=True)
class Mission:
    """What a simulation has to know of a mission; robots are in the order of the model."""

    name: str
    robots: list[Robot]
    obstacles: list[Obstacle]


class Physics:
    """Moves the robots of a mission: the base of every world.

    Attributes
    ----------
    late
        How many commands came too late in the last tick. It stays 0 where time stands still
        between two ticks.
    """

    late: int = 0

    @staticmethod
    def add_options(parser: argparse.ArgumentParser) -> None:
        """Add options of this world to its command line."""

    def __init__(self, mission: Mission, options: argparse.Namespace) -> None:
        """Prepare to move the robots; raise ``WorldError`` if the mission cannot be flown here."""

    def reset(self, seed: int) -> None:
        """Put every robot at its start, at rest; all random numbers derive from the seed."""
        raise NotImplementedError

    def move(self) -> Sequence[float]:
        """Move all robots for a tick, as commanded; return the distance of each."""
        raise NotImplementedError

    def measured(self, _sensor: Sensor) -> tuple[int, int] | None:
        """Return how many samples a sensor took in the last tick, and how many are valid.

        With None, the samples of the sensor are drawn as in mrsfi's own simulation.
        """
        return None

    def close(self) -> None:
        """End what runs beside this process."""


class World:
    """Robots that physics move, and the energy of their ways and samples.

    Attributes
    ----------
    robots
        In the order of the mission, the same objects for ever.
    """

    def __init__(self, robots: Sequence[Robot], physics: Physics) -> None:
        self.robots = robots
        self._physics = physics

    @property
    def late(self) -> int:
        """How many commands came too late in the last tick."""
        return int(self._physics.late)

    def reset(self, seed: int) -> None:
        """Go back to the start, with another seed of samples and noise."""
        self._samples = np.random.default_rng(seed)
        self._noise = np.random.default_rng((seed, 1))
        for robot in self.robots:
            robot.reset()
        self._physics.reset(seed)

    def step(self) -> None:
        """Fly one tick; a robot still moves and samples in the tick in which its energy ends."""
        ways = self._physics.move()
        if ways is None or len(ways) != len(self.robots):
            raise WorldError(f"world.move returned {ways}; expected a distance for each robot")
        for robot, way in zip(self.robots, ways, strict=True):
            spent = _checked(robot, way) * robot.energy_per_distance + self._sample(robot)
            robot.energy = max(robot.energy - spent, 0.0)
            robot.reported = self._scattered(robot)

    def _sample(self, robot: Robot) -> float:
        """Have each active sensor take its samples; return the energy that they cost."""
        spent = 0.0
        for sensor in robot.sensors:
            n, n_valid = self._physics.measured(sensor) or self._drawn(sensor.samples_per_tick)
            sensor.is_active = sensor.is_wanted and robot.has_power
            if sensor.is_active:
                sensor.count += int(n_valid)
                spent += n * sensor.energy_per_sample
        return spent

    def _drawn(self, n: int) -> tuple[int, int]:
        """Return samples and valid ones: each is valid with probability 1/n, on or off."""
        return n, int(self._samples.binomial(n, 1.0 / n))

    def _scattered(self, robot: Robot) -> Place:
        """Return the position that a robot reports: uniform in the disc of its noise."""
        if not robot.position_noise:
            return robot.position
        share, turn = self._noise.random(2)
        off, angle = robot.position_noise * math.sqrt(share), math.tau * turn
        x, y, z = robot.position
        return x + off * math.cos(angle), y + off * math.sin(angle), z


def _checked(robot: Robot, way: float) -> float:
    """Return the distance of a robot that physics moved; it and the robot's values are floats."""
    values = (*robot.position, robot.speed, way)
    if len(values) != len(MOVED):
        raise WorldError(
            f"world.move: robot {robot.name}, position is {robot.position}; expected x, y and z"
        )
    x, y, z, robot.speed, distance = (
        _finite(robot, name, value) for name, value in zip(MOVED, values, strict=True)
    )
    robot.position = x, y, z
    return distance


def _finite(robot: Robot, name: str, value: Any) -> float:
    """Return a number of any type as a float."""
    try:
        number = float(value)
    except (TypeError, ValueError):
        number = math.nan
    if not math.isfinite(number):
        raise WorldError(
            f"world.move: robot {robot.name}, {name} is {value}; expected a finite number"
        )
    return number
