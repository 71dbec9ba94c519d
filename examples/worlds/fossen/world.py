"""A mission under water, after Fossen: BlueROV2s in six degrees of freedom.

By default a distance unit is 0.1 m: the robots of uuv_sampling dive at 0.4 and 0.5 m/s. Autopilots
hold depth, turn the bow to the heading, and go ahead once it points there; thrusters saturate.
"""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np

sys.path.append(str(Path(__file__).parents[1]))

from robots import Mission, Physics
from serving import serve
from vehicle import Array, Parameters, Vehicles

TICK_S = 1.0
STEP_S = 0.05

GREATEST = np.array([[88.0, 88.0, 137.0, 0.0, 0.0, 12.0]]).T  # N and N m: 9 kgf in the plane, 14 up
SURGE_GAIN, SWAY_GAIN = 200.0, 200.0  # N a m/s
DEPTH_GAIN, HEAVE_GAIN = 200.0, 60.0  # N a m, N a m/s
YAW_GAIN, TURN_GAIN = 10.0, 4.0  # N m a rad, N m a rad/s
FACING = 0.3  # rad: it goes ahead as soon as its bow is no farther off the heading


class Sea(Physics):
    """Vehicles that obstacles do not stop: only the goals know them."""

    @staticmethod
    def add_options(parser: argparse.ArgumentParser) -> None:
        """Add the scale."""
        parser.add_argument("--unit", type=float, default=0.1, help="metres a distance unit")

    def __init__(self, mission: Mission, options: argparse.Namespace) -> None:
        self._robots = mission.robots
        self._unit_m = options.unit
        self._known = Parameters()
        self._vehicles = Vehicles(len(mission.robots), self._known)

    def reset(self, _seed: int) -> None:
        """Put every vehicle at its start, at rest."""
        self._vehicles.reset()

    def move(self) -> Sequence[float]:
        """Dive for a tick, as commanded; return the distance of each vehicle."""
        told = np.array([robot.heading for robot in self._robots])
        speed = np.array([robot.wanted_speed for robot in self._robots]) * self._unit_m
        speed *= np.hypot(*told.T)
        has_power = np.array([robot.has_power for robot in self._robots])
        heading = np.arctan2(told[:, 1], told[:, 0])
        metres = np.zeros(len(self._robots))
        for _ in range(round(TICK_S / STEP_S)):
            self._vehicles.step(has_power * self._thrust(heading, speed), STEP_S)
            metres += np.hypot(*self._vehicles.velocity[:2]) * STEP_S
        ends = self._vehicles.pose[:3].T / self._unit_m
        speeds = np.hypot(*self._vehicles.world_velocity()[:2]) / self._unit_m
        for robot, (dx, dy, deeper), now in zip(self._robots, ends, speeds, strict=True):
            x, y, z = robot.start
            robot.position = x + float(dx), y + float(dy), z - float(deeper)
            robot.speed = float(now)
        return (metres / self._unit_m).tolist()

    def _thrust(self, heading: Array, speed: Array) -> Array:
        """Return the forces and moments that the autopilots demand, shape ``(6, n)``."""
        u, v, w, _, _, r = self._vehicles.velocity
        _, _, depth, _, _, yaw = self._vehicles.pose
        off = np.where(speed > 0.0, np.remainder(heading - yaw + np.pi, 2.0 * np.pi) - np.pi, 0.0)
        ahead = np.where(np.abs(off) < FACING, speed, 0.0)
        known = self._known
        drag = (known.linear[0, 0] + known.quadratic[0, 0] * ahead) * ahead
        floats = known.weight - known.buoyancy
        wanted = np.zeros((6, len(self._robots)))
        wanted[0] = SURGE_GAIN * (ahead - u) + drag
        wanted[1] = -SWAY_GAIN * v
        wanted[2] = -DEPTH_GAIN * depth - HEAVE_GAIN * w - floats
        wanted[5] = YAW_GAIN * off - TURN_GAIN * r
        return np.clip(wanted, -GREATEST, GREATEST)


if __name__ == "__main__":
    sys.exit(serve("Fossen's equations", Sea))
