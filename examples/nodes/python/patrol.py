"""Drives three huskies round a yard, past silos and each other: `python patrol.py URL`."""

import math
import sys
import threading

import roslibpy

ROUTES = {
    "husky1": [(-40, -20), (-30, 30)],
    "husky2": [(40, -20), (-25, -35), (20, 35)],
    "husky3": [(20, 10), (0, 40), (-25, -30)],
}
SILOS = [(0, 0, 10), (-15, 25, 5)]  # x, y, radius in metres
ROOM = 8.0  # metres that we like to have between two hulls
RADIUS = 1.0
ARRIVED = 4.0
TOP_SPEED, TOP_TURN = 1.6, 0.7  # metres and radians a second
SHIFT, RANGE = 300.0, 400.0  # seconds, and metres on a full charge


class Husky:
    """What we know of one of them: it changes as it is heard of."""

    def __init__(self) -> None:
        self.pose = None
        self.charge = 1.0
        self.leg = 0


class Patrol:
    """Answers each odometry of a husky with its velocity."""

    def __init__(self, ros: roslibpy.Ros) -> None:
        self.reset()
        self.drives = {}
        for name in ROUTES:
            self.drives[name] = roslibpy.Topic(ros, f"/{name}/cmd_vel", "geometry_msgs/Twist")
            self.drives[name].advertise()
            self._hear(ros, f"/{name}/battery", "sensor_msgs/BatteryState", self._on_battery, name)
            self._hear(ros, f"/{name}/odom", "nav_msgs/Odometry", self._on_odometry, name)
        self._hear(ros, "/clock", "rosgraph_msgs/Clock", self._on_clock)
        roslibpy.Service(ros, "/patrol/reset", "std_srvs/Trigger").advertise(self._on_reset)

    def _hear(self, ros, topic, kind, callback, *arguments):
        roslibpy.Topic(ros, topic, kind).subscribe(lambda message: callback(message, *arguments))

    def reset(self) -> None:
        """Go back to the start of the shift."""
        self.huskies = {name: Husky() for name in ROUTES}
        self.now = 0.0

    def _on_reset(self, _request, response) -> bool:
        self.reset()
        response.update(success=True, message="at the start of the shift")
        return True

    def _on_clock(self, message) -> None:
        self.now = message["clock"]["secs"] + message["clock"]["nsecs"] * 1e-9

    def _on_battery(self, message, name: str) -> None:
        self.huskies[name].charge = message["percentage"]

    def _on_odometry(self, message, name: str) -> None:
        at, turned = message["pose"]["pose"]["position"], message["pose"]["pose"]["orientation"]
        yaw = 2.0 * math.atan2(turned["z"], turned["w"])
        self.huskies[name].pose = (at["x"], at["y"], yaw)
        speed, turn = self.steer(name)
        zero = {"x": 0.0, "y": 0.0, "z": 0.0}
        velocity = {"linear": {**zero, "x": speed}, "angular": {**zero, "z": turn}}
        self.drives[name].publish(roslibpy.Message(velocity))

    def steer(self, name: str) -> tuple[float, float]:
        """Return speed and turn: towards the next way-point, off what is near, then right of it."""
        husky, route = self.huskies[name], ROUTES[name]
        x, y, yaw = husky.pose
        if math.dist((x, y), route[husky.leg]) < ARRIVED:
            husky.leg = (husky.leg + 1) % len(route)
        to_x, to_y = route[husky.leg][0] - x, route[husky.leg][1] - y
        length = math.hypot(to_x, to_y)
        to_x, to_y = to_x / length, to_y / length
        for other_x, other_y, radius in self._around(name):
            off_x, off_y = x - other_x, y - other_y
            distance = max(math.hypot(off_x, off_y), 0.001)
            push = 2.0 * max(0.0, 1.0 - (distance - radius - RADIUS) / ROOM) / distance
            to_x += push * (off_x - off_y)
            to_y += push * (off_y + off_x)
        error = math.remainder(math.atan2(to_y, to_x) - yaw, math.tau)
        turn = max(-TOP_TURN, min(TOP_TURN, error))
        affordable = husky.charge * RANGE / max(SHIFT - self.now, 1.0)
        return min(TOP_SPEED, 0.95 * affordable) * max(0.1, math.cos(error - turn)), turn

    def _around(self, name: str):
        """Yield place and radius of all that a husky could hit."""
        yield from SILOS
        for other, husky in self.huskies.items():
            if other != name and husky.pose is not None:
                yield husky.pose[0], husky.pose[1], RADIUS


client = roslibpy.Ros(sys.argv[1], transport="asyncio")
client.run()
Patrol(client)
threading.Event().wait()
