"""Shared by all worlds: robots that obey heading and speed, take samples and spend energy."""

import tomllib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol, TypeAlias

import numpy as np

MISSION = Path(__file__).with_name("uuv_sampling.toml")

Place: TypeAlias = tuple[float, float, float]


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
    ``position`` and ``speed`` are true.
    """

    name: str
    start: Place
    energy_at_start: float
    energy_per_distance: float
    greatest_speed: float
    sensors: list[Sensor]
    energy: float = 0.0
    heading: tuple[float, float] = (0.0, 0.0)
    commanded_speed: float = 0.0
    position: Place = (0.0, 0.0, 0.0)
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
        self.position, self.speed = self.start, 0.0
        for sensor in self.sensors:
            sensor.count, sensor.is_active, sensor.is_wanted = 0, False, True


@dataclass(frozen=True, slots=True)
class Obstacle:
    """A cylinder that stands upright."""

    name: str
    center: Place
    radius: float


class Physics(Protocol):
    """Moves the robots with which it was made."""

    def reset(self) -> None:
        """Put every robot at its start, at rest."""

    def move(self) -> Sequence[float]:
        """Move all robots for a tick, as commanded; return the distance of each."""


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
        self.reset(0)

    def reset(self, seed: int) -> None:
        """Go back to the start, with another seed of the samples."""
        self._random = np.random.default_rng(seed)
        for robot in self.robots:
            robot.reset()
        self._physics.reset()

    def step(self) -> None:
        """Fly one tick; a robot still moves and samples in the tick in which its energy ends."""
        for robot, way in zip(self.robots, self._physics.move(), strict=True):
            spent = way * robot.energy_per_distance + self._sample(robot)
            robot.energy = max(robot.energy - spent, 0.0)

    def _sample(self, robot: Robot) -> float:
        """Have each active sensor take its samples; return the energy that they cost."""
        spent = 0.0
        for sensor in robot.sensors:
            n = sensor.samples_per_tick
            n_valid = int(self._random.binomial(n, 1.0 / n))  # drawn whether it is on or off
            sensor.is_active = sensor.is_wanted and robot.has_power
            if sensor.is_active:
                sensor.count += n_valid
                spent += n * sensor.energy_per_sample
        return spent


def read_mission(path: Path = MISSION) -> tuple[list[Robot], list[Obstacle]]:
    """Return the robots and the obstacles of a mission."""
    told = tomllib.loads(path.read_text(encoding="utf-8"))
    robots = [_robot(name, **each) for name, each in told["robots"].items()]
    for robot in robots:
        robot.reset()
    obstacles = [
        Obstacle(name, _place(each["center"]), float(each["radius"]))
        for name, each in told["obstacles"].items()
    ]
    return robots, obstacles


def _robot(name: str, *, start: list[float], sensors: dict[str, Any], **numbers: float) -> Robot:
    return Robot(
        name,
        _place(start),
        float(numbers["energy"]),
        float(numbers["energy_per_distance"]),
        float(numbers["greatest_speed"]),
        [
            Sensor(each, told["samples"], float(told["energy"]), told["tells_position"])
            for each, told in sensors.items()
        ],
    )


def _place(numbers: list[float]) -> Place:
    x, y, z = map(float, numbers)
    return x, y, z
