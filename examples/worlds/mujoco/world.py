"""The mission uuv_sampling on MuJoCo: vehicles with inertia and drag in sea water.

A distance unit is a metre. What a vehicle runs into stops it.
"""

import sys
from collections.abc import Sequence
from pathlib import Path

import mujoco
import numpy as np

sys.path.append(str(Path(__file__).parents[1]))

from robots import Obstacle, Robot
from serving import serve

WATER = Path(__file__).with_name("water.xml")
TICK_S = 1.0


class SeaWater:
    """Vehicles in water, which slide in the plane of their start; obstacles are cylinders."""

    def __init__(self, robots: Sequence[Robot], obstacles: Sequence[Obstacle]) -> None:
        self._robots = robots
        self._model = _model(robots, obstacles)
        self._data = mujoco.MjData(self._model)
        self._gain, self._greatest_thrust = self._model.numeric("thruster").data

    def reset(self) -> None:
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


def _model(robots: Sequence[Robot], obstacles: Sequence[Obstacle]) -> mujoco.MjModel:
    """Return water with vehicles and obstacles in it."""
    water = mujoco.MjSpec.from_file(str(WATER))
    vehicle, obstacle = water.find_default("vehicle"), water.find_default("obstacle")
    for robot in robots:
        body = water.worldbody.add_body(name=robot.name, pos=robot.start)
        body.add_joint(vehicle, name=f"{robot.name}/x", axis=(1, 0, 0))
        body.add_joint(vehicle, name=f"{robot.name}/y", axis=(0, 1, 0))
        body.add_geom(vehicle, name=robot.name)
    for each in obstacles:
        size = (each.radius, 10, 0)
        water.worldbody.add_geom(obstacle, name=each.name, pos=each.center, size=size)
    return water.compile()


if __name__ == "__main__":
    sys.exit(serve("MuJoCo", SeaWater))
