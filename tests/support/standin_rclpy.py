"""Runs a script with a stand-in for rclpy: ``python -m tests.support.standin_rclpy SCRIPT``.

It has what the example of a node uses: a node, publishers, subscriptions and a service. Its
executor takes messages in the order in which they were sent, which rclpy does not promise. Types of
messages are mrsfi's own. This is no evidence of how rclpy behaves.
"""

import os
import runpy
import sys
from types import ModuleType, SimpleNamespace

from cyclonedds.idl import IdlStruct

from mrsfi_bridge.settings import TypeTable
from mrsfi_runtime.transport.ros2 import Types
from tests.support import ros2_node

TYPES = Types(TypeTable(ros=2))
MESSAGES = {
    "geometry_msgs.msg": ("Twist",),
    "nav_msgs.msg": ("Odometry",),
    "rosgraph_msgs.msg": ("Clock",),
    "sensor_msgs.msg": ("BatteryState",),
}


def message(name):
    """Return a function that makes an empty message, as a class of rclpy does."""
    kind = TYPES.message(name)

    def make():
        return kind.instance({})

    make.made = kind.made
    return make


class Executor(ros2_node.Executor):
    """Takes messages and requests in the order in which they were sent."""

    def spin(self):
        """Run for ever."""
        self.serve_parameters()
        while True:
            taken = []
            while more := [*self.arrived()]:
                taken += more
            for _, _, execute, message in sorted(taken, key=lambda each: each[:2]):
                execute(message)
            if not taken:
                self.waits.wait(10**9)

    def arrived(self):
        """Take what has arrived; a message that was sent earlier may be there a moment later."""
        for place, (reader, execute) in enumerate((*self.subscriptions, *self.services)):
            for each in reader.take(100):
                if isinstance(each, IdlStruct):
                    yield each.sample_info.source_timestamp, place, execute, each


class Node:
    """A node of rclpy."""

    def __init__(self, name):
        self.executor = Executor(int(os.environ["ROS_DOMAIN_ID"]), name)

    def create_publisher(self, kind, topic, _depth):
        return Publisher(self.executor.writer(f"rt{topic}", kind.made, ros2_node.QOS))

    def create_subscription(self, kind, topic, callback, _depth):
        reader = self.executor.reader(f"rt{topic}", kind.made, ros2_node.QOS)
        self.executor.subscriptions.append((reader, callback))

    def create_service(self, kind, name, callback):
        self.executor.serve(
            name,
            kind.request,
            kind.response,
            lambda request: vars(callback(request, SimpleNamespace())),
        )


class Publisher:
    """A publisher of rclpy."""

    def __init__(self, writer):
        self.writer = writer

    def publish(self, message: IdlStruct):
        self.writer.write(message)


class Trigger:
    """The service that resets."""

    request, response = ros2_node.Trigger, ros2_node.Triggered


def main() -> None:
    """Run the script with the modules that it imports."""
    modules = {
        package: {name: message(f"{package.partition('.')[0]}/{name}") for name in names}
        for package, names in MESSAGES.items()
    }
    modules |= {
        "rclpy": {"init": lambda: None, "spin": lambda node: node.executor.spin()},
        "rclpy.node": {"Node": Node},
        "std_srvs.srv": {"Trigger": Trigger},
    }
    for name, content in modules.items():
        for each in (name.partition(".")[0], name):
            sys.modules.setdefault(each, ModuleType(each))
        vars(sys.modules[name]).update(content)
    script, *sys.argv[1:] = sys.argv[1:]
    runpy.run_path(script, run_name="__main__")


if __name__ == "__main__":
    main()
