"""The mission uuv_sampling on ir-sim: robots with two driven wheels on level ground.

A distance unit is 0.2 m, so that the mission's robots drive at 1 m/s and at most 2.
"""

import math
import sys
from collections.abc import Sequence
from contextlib import redirect_stdout
from io import StringIO
from pathlib import Path

with redirect_stdout(StringIO()):  # it tells which windows it has not got, and needs none
    import irsim

sys.path.append(str(Path(__file__).parents[1]))

from robots import Obstacle, Robot
from serving import serve

GROUND = Path(__file__).with_name("ground.yaml")
TICK_S = 1.0
UNIT_M = 0.2
RADIUS_M = 0.25
TURN_GAIN = 4.0  # rad/s a rad off the heading
FASTEST_TURN = 2.0  # rad/s
FACING = 0.3  # rad: it drives as soon as it is no farther off, and turns on the spot until then


class Ground:
    """Robots that turn on the spot until they face their heading, and drive then."""

    def __init__(self, robots: Sequence[Robot], obstacles: Sequence[Obstacle]) -> None:
        self._robots = robots
        self._ground = irsim.make(str(GROUND), headless=True, log_level="ERROR")
        self._driven = [_driven(self._ground, robot) for robot in robots]
        for each in self._driven:
            self._ground.add_object(each)
        for each in obstacles:
            self._ground.add_object(_fixed(self._ground, each))
        self._step_s = self._ground.step_time
        self._n_steps = round(TICK_S / self._step_s)

    def reset(self) -> None:
        """Put every robot at its start, at rest."""
        self._ground.reset()

    def move(self) -> Sequence[float]:
        """Drive for a tick, as commanded; return the distance of each robot."""
        metres = [0.0] * len(self._robots)
        for _ in range(self._n_steps):
            before = [_place(each) for each in self._driven]
            commands = map(_command, self._robots, self._driven)
            self._ground.step([*commands], [each.id for each in self._driven])
            for n, each in enumerate(self._driven):
                metres[n] += math.dist(before[n], _place(each))
        for robot, each in zip(self._robots, self._driven, strict=True):
            x, y = _place(each)
            robot.position = x / UNIT_M, y / UNIT_M, robot.start[2]
            robot.speed = math.hypot(*map(float, each.velocity_xy.ravel())) / UNIT_M
        return [way / UNIT_M for way in metres]


def _command(robot: Robot, driven: "irsim.world.ObjectBase") -> list[float]:
    """Return speed and turn of the wheels that follow the commands of a robot."""
    x, y = robot.heading
    wanted = robot.wanted_speed * UNIT_M * math.hypot(x, y)
    if not wanted:
        return [0.0, 0.0]
    off = math.remainder(math.atan2(y, x) - float(driven.state[2, 0]), math.tau)
    turn = min(max(TURN_GAIN * off, -FASTEST_TURN), FASTEST_TURN)
    return [wanted if abs(off) < FACING else 0.0, turn]


def _driven(ground: "irsim.EnvBase", robot: Robot) -> "irsim.world.ObjectBase":
    fastest = robot.greatest_speed * UNIT_M
    x, y, _ = robot.start
    return ground.create_robot(
        name=robot.name,
        kinematics={"name": "diff"},
        shape={"name": "circle", "radius": RADIUS_M},
        state=[x * UNIT_M, y * UNIT_M, 0.0],
        vel_min=[0.0, -FASTEST_TURN],
        vel_max=[fastest, FASTEST_TURN],
    )


def _fixed(ground: "irsim.EnvBase", obstacle: Obstacle) -> "irsim.world.ObjectBase":
    x, y, _ = obstacle.center
    return ground.create_obstacle(
        name=obstacle.name,
        shape={"name": "circle", "radius": obstacle.radius * UNIT_M},
        state=[x * UNIT_M, y * UNIT_M, 0.0],
    )


def _place(driven: "irsim.world.ObjectBase") -> tuple[float, float]:
    x, y = map(float, driven.state[:2, 0])
    return x, y


if __name__ == "__main__":
    sys.exit(serve("ir-sim", Ground))
