"""A mission on ir-sim: robots with two driven wheels on level ground.

By default a distance unit is 0.2 m: the robots of uuv_sampling drive at 1 m/s and at most 2.
"""

import argparse
import math
import sys
from collections.abc import Sequence
from contextlib import redirect_stdout
from io import StringIO
from pathlib import Path

with redirect_stdout(StringIO()):  # it tells which windows it has not got, and needs none
    import irsim

sys.path.append(str(Path(__file__).parents[1]))

from robots import Mission, Obstacle, Physics, Robot
from serving import serve

GROUND = Path(__file__).with_name("ground.yaml")
TICK_S = 1.0
BUMPER_M = 0.05  # around the robot's disc
TURN_GAIN = 4.0  # rad/s a rad off the heading
FASTEST_TURN = 2.0  # rad/s
FACING = 0.3  # rad: it drives as soon as it is no farther off, and turns on the spot until then


class Ground(Physics):
    """Robots that turn on the spot until they face their heading, and drive then."""

    @staticmethod
    def add_options(parser: argparse.ArgumentParser) -> None:
        """Add the scale."""
        parser.add_argument("--unit", type=float, default=0.2, help="metres a distance unit")

    def __init__(self, mission: Mission, options: argparse.Namespace) -> None:
        self._robots = mission.robots
        self._unit_m = options.unit
        self._ground = irsim.make(str(GROUND), headless=True, log_level="ERROR")
        self._driven = [self._made(robot) for robot in mission.robots]
        for each in (*self._driven, *map(self._fixed, mission.obstacles)):
            self._ground.add_object(each)
        self._n_steps = round(TICK_S / self._ground.step_time)

    def reset(self, _seed: int) -> None:
        """Put every robot at its start, at rest."""
        self._ground.reset()

    def move(self) -> Sequence[float]:
        """Drive for a tick, as commanded; return the distance of each robot."""
        metres = [0.0] * len(self._robots)
        for _ in range(self._n_steps):
            before = [_place(each) for each in self._driven]
            commands = map(self._command, self._robots, self._driven)
            self._ground.step([*commands], [each.id for each in self._driven])
            for n, each in enumerate(self._driven):
                metres[n] += math.dist(before[n], _place(each))
        for robot, each in zip(self._robots, self._driven, strict=True):
            x, y = _place(each)
            robot.position = x / self._unit_m, y / self._unit_m, robot.start[2]
            robot.speed = math.hypot(*map(float, each.velocity_xy.ravel())) / self._unit_m
        return [way / self._unit_m for way in metres]

    def _command(self, robot: Robot, driven: "irsim.world.ObjectBase") -> list[float]:
        """Return speed and turn of the wheels that follow the commands of a robot."""
        x, y = robot.heading
        wanted = robot.wanted_speed * self._unit_m * math.hypot(x, y)
        if not wanted:
            return [0.0, 0.0]
        off = math.remainder(math.atan2(y, x) - float(driven.state[2, 0]), math.tau)
        turn = min(max(TURN_GAIN * off, -FASTEST_TURN), FASTEST_TURN)
        return [wanted if abs(off) < FACING else 0.0, turn]

    def _made(self, robot: Robot) -> "irsim.world.ObjectBase":
        fastest = robot.greatest_speed * self._unit_m
        x, y, _ = robot.start
        return self._ground.create_robot(
            name=robot.name,
            kinematics={"name": "diff"},
            shape={"name": "circle", "radius": robot.radius * self._unit_m + BUMPER_M},
            state=[x * self._unit_m, y * self._unit_m, 0.0],
            vel_min=[0.0, -FASTEST_TURN],
            vel_max=[fastest, FASTEST_TURN],
        )

    def _fixed(self, obstacle: Obstacle) -> "irsim.world.ObjectBase":
        x, y, _ = obstacle.center
        shape = {"name": "circle", "radius": obstacle.radius * self._unit_m}
        if obstacle.corners:
            x, y = 0.0, 0.0
            places = [[u * self._unit_m, v * self._unit_m] for u, v, _ in obstacle.corners]
            shape = {"name": "polygon", "vertices": places}
        state = [x * self._unit_m, y * self._unit_m, 0.0]
        return self._ground.create_obstacle(name=obstacle.name, shape=shape, state=state)


def _place(driven: "irsim.world.ObjectBase") -> tuple[float, float]:
    x, y = map(float, driven.state[:2, 0])
    return x, y


if __name__ == "__main__":
    sys.exit(serve("ir-sim", Ground))
