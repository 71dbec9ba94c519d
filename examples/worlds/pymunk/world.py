"""A mission on pymunk: hovercraft that glide, push each other, and bounce off obstacles.

A distance unit is a metre.
"""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

import pymunk

sys.path.append(str(Path(__file__).parents[1]))

from robots import Mission, Obstacle, Physics, Robot
from serving import serve

TICK_S = 1.0
STEP_S = 0.05
RESPONSE_S = 0.4  # in which most of a wrong speed is gone
WALL_M = 0.05  # half the thickness of the side of a polygon


class Hall(Physics):
    """Discs with inertia, all of one density, that propellers accelerate in any direction."""

    @staticmethod
    def add_options(parser: argparse.ArgumentParser) -> None:
        """Add propellers and bounce."""
        parser.add_argument("--thrust", type=float, default=8.0, help="greatest, in m/s²")
        parser.add_argument("--bounce", type=float, default=0.5, help="0 to 1: speed kept")

    def __init__(self, mission: Mission, options: argparse.Namespace) -> None:
        self._mission = mission
        self._options = options

    def reset(self, _seed: int) -> None:
        """Build the hall anew: pymunk remembers contacts, which would change the next flight."""
        self._space = pymunk.Space()
        self._hulls = [self._add_hull(robot) for robot in self._mission.robots]
        for each in self._mission.obstacles:
            for shape in _shapes(each, self._space.static_body):
                shape.elasticity = self._options.bounce
                self._space.add(shape)

    def move(self) -> Sequence[float]:
        """Glide for a tick, as commanded; return the distance of each hovercraft."""
        metres = [0.0] * len(self._hulls)
        crew = [*zip(self._mission.robots, self._hulls, strict=True)]
        for _ in range(round(TICK_S / STEP_S)):
            for robot, hull in crew:
                wanted = pymunk.Vec2d(*robot.heading) * robot.wanted_speed
                push = (wanted - hull.velocity) * (robot.has_power / RESPONSE_S)
                if push.length > self._options.thrust:
                    push = push.scale_to_length(self._options.thrust)
                drag = 0.0 if robot.has_power else 0.5
                hull.force = hull.mass * (push - hull.velocity * drag)
            self._space.step(STEP_S)
            for n, hull in enumerate(self._hulls):
                metres[n] += hull.velocity.length * STEP_S
        for robot, hull in crew:
            robot.position = hull.position.x, hull.position.y, robot.start[2]
            robot.speed = hull.velocity.length
        return metres

    def _add_hull(self, robot: Robot) -> pymunk.Body:
        hull = pymunk.Body()
        hull.position = robot.start[:2]
        disc = pymunk.Circle(hull, robot.radius)
        disc.density = 1.0
        disc.elasticity = self._options.bounce
        self._space.add(hull, disc)
        return hull


def _shapes(obstacle: Obstacle, ground: pymunk.Body) -> list[pymunk.Shape]:
    """Return a disc, or the sides of a polygon."""
    if not obstacle.corners:
        return [pymunk.Circle(ground, obstacle.radius, obstacle.center[:2])]
    places = [corner[:2] for corner in obstacle.corners]
    ends = zip(places, (*places[1:], places[0]), strict=True)
    return [pymunk.Segment(ground, start, end, WALL_M) for start, end in ends]


if __name__ == "__main__":
    sys.exit(serve("pymunk", Hall))
