"""A mission on MuJoCo: vehicles with inertia and drag in sea water.

A distance unit is a metre. What a vehicle runs into stops it.
"""

import argparse
import math
import sys
from collections.abc import Sequence
from pathlib import Path

import mujoco
import numpy as np

sys.path.append(str(Path(__file__).parents[1]))

from robots import Mission, Obstacle, Physics
from serving import serve

WATER = Path(__file__).with_name("water.xml")
TICK_S = 1.0
HALF_HEIGHT_M = 10.0
HALF_THICKNESS_M = 0.05  # of a wall


class SeaWater(Physics):
    """Vehicles in water, which slide in the plane of their start; obstacles stand upright."""

    @staticmethod
    def add_options(parser: argparse.ArgumentParser) -> None:
        """Add the current."""
        parser.add_argument(
            "--current", type=float, nargs=2, default=(0.0, 0.0), metavar=("X", "Y"), help="m/s"
        )

    def __init__(self, mission: Mission, options: argparse.Namespace) -> None:
        self._robots = mission.robots
        self._model = _model(mission)
        self._model.opt.wind[:2] = options.current
        self._data = mujoco.MjData(self._model)
        gain, greatest_thrust = self._model.numeric("thruster").data
        volumes = np.array([robot.radius**3 for robot in mission.robots])
        self._gain = gain * volumes[:, None]
        self._greatest_thrust = greatest_thrust * volumes

    def reset(self, _seed: int) -> None:
        """Put every vehicle at its start, at rest."""
        mujoco.mj_resetData(self._model, self._data)

    def move(self) -> Sequence[float]:
        """Move all vehicles for a tick, as commanded; return the distance of each."""
        has_power = np.array([robot.has_power for robot in self._robots])
        wanted = np.array([robot.heading for robot in self._robots])
        wanted *= np.array([[robot.wanted_speed] for robot in self._robots])
        velocity = self._data.qvel.reshape(-1, 2)  # a view: it changes with every step
        step_s = self._model.opt.timestep
        metres = np.zeros(len(self._robots))
        for _ in range(round(TICK_S / step_s)):
            thrust = self._gain * (wanted - velocity)
            size = np.hypot(*thrust.T)
            share = has_power * self._greatest_thrust / np.maximum(size, self._greatest_thrust)
            self._data.qfrc_applied[:] = (thrust * share[:, None]).ravel()
            mujoco.mj_step(self._model, self._data)
            metres += np.hypot(*velocity.T) * step_s
        for robot, (dx, dy), speed in zip(
            self._robots, self._data.qpos.reshape(-1, 2), np.hypot(*velocity.T), strict=True
        ):
            x, y, z = robot.start
            robot.position, robot.speed = (x + float(dx), y + float(dy), z), float(speed)
        return metres.tolist()


def _model(mission: Mission) -> mujoco.MjModel:
    """Return water with vehicles and obstacles in it."""
    water = mujoco.MjSpec.from_file(str(WATER))
    vehicle = water.find_default("vehicle")
    for robot in mission.robots:
        size = robot.radius, 0, 0
        mass = vehicle.geom.mass * robot.radius**3
        body = water.worldbody.add_body(name=robot.name, pos=robot.start)
        body.add_joint(vehicle, name=f"{robot.name}/x", axis=(1, 0, 0))
        body.add_joint(vehicle, name=f"{robot.name}/y", axis=(0, 1, 0))
        body.add_geom(vehicle, name=robot.name, size=size, mass=mass)
    for each in mission.obstacles:
        _add_obstacle(water, each)
    return water.compile()


def _add_obstacle(water: mujoco.MjSpec, obstacle: Obstacle) -> None:
    """Add a cylinder, or the walls of a prism."""
    kind = water.find_default("obstacle")
    if not obstacle.corners:
        size = obstacle.radius, HALF_HEIGHT_M, 0
        water.worldbody.add_geom(kind, name=obstacle.name, pos=obstacle.center, size=size)
    for n, wall in enumerate(obstacle.walls):
        water.worldbody.add_geom(
            kind,
            name=f"{obstacle.name}/{n}",
            type=mujoco.mjtGeom.mjGEOM_BOX,
            pos=wall.middle,
            size=(wall.length / 2, HALF_THICKNESS_M, HALF_HEIGHT_M),
            quat=(math.cos(wall.angle / 2), 0, 0, math.sin(wall.angle / 2)),
        )


if __name__ == "__main__":
    sys.exit(serve("MuJoCo", SeaWater))
