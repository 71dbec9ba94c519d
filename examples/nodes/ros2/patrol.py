"""Drives three huskies round a yard, past silos and each other: `ros2 launch patrol.launch.py`."""

import math
from functools import partial

import rclpy
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from rclpy.node import Node
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import BatteryState
from std_srvs.srv import Trigger

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


class Patrol(Node):
    """Answers each odometry of a husky with its velocity."""

    def __init__(self) -> None:
        super().__init__("patrol")
        self.begin()
        self.drives = {
            name: self.create_publisher(Twist, f"/{name}/cmd_vel", 10) for name in ROUTES
        }
        for name in ROUTES:
            self.hear(Odometry, f"/{name}/odom", partial(self.on_odometry, name))
        for name in ROUTES:
            self.hear(BatteryState, f"/{name}/battery", partial(self.on_battery, name))
        self.hear(Clock, "/clock", self.on_clock)
        self.create_service(Trigger, "/patrol/reset", self.on_reset)

    def hear(self, kind, topic, callback):
        """Receive the messages of a topic."""
        self.create_subscription(kind, topic, callback, 10)

    def begin(self) -> None:
        """Go back to the start of the shift."""
        self.huskies = {name: Husky() for name in ROUTES}
        self.now = 0.0

    def on_reset(self, _request, response):
        """Answer a call of the service."""
        self.begin()
        response.success, response.message = True, "at the start of the shift"
        return response

    def on_clock(self, message) -> None:
        """Note the time of the shift."""
        self.now = message.clock.sec + message.clock.nanosec * 1e-9

    def on_battery(self, name: str, message) -> None:
        """Note the charge of a husky."""
        self.huskies[name].charge = message.percentage

    def on_odometry(self, name: str, message) -> None:
        """Note the place of a husky, and command its velocity."""
        at, turned = message.pose.pose.position, message.pose.pose.orientation
        self.huskies[name].pose = (at.x, at.y, 2.0 * math.atan2(turned.z, turned.w))
        velocity = Twist()
        velocity.linear.x, velocity.angular.z = self.steer(name)
        self.drives[name].publish(velocity)

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


def main() -> None:
    """Drive until the node is ended."""
    rclpy.init()
    rclpy.spin(Patrol())


if __name__ == "__main__":
    main()
