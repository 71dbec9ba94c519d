"""A node that does one thing wrong: ``python tests/support/bad_node.py WHAT URL``.

It hears the huskies of the example of nodes and answers one of them, well until the fifth time.
"""

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from contextlib import suppress

from websockets.frames import Frame, Opcode
from websockets.sync.client import ClientConnection, connect

HUSKY, TWIST = "/husky1/cmd_vel", "geometry_msgs/Twist"
RESET = "/patrol/reset"


def say(socket: ClientConnection, op: str, **values: object) -> None:
    """Send an operation of the protocol."""
    socket.send(json.dumps({"op": op, **values}))


def drive(socket: ClientConnection, speed: object = 0.5) -> None:
    """Tell a husky to go ahead."""
    say(socket, "publish", topic=HUSKY, msg={"linear": {"x": speed}})


def flood(socket: ClientConnection) -> None:
    """Command 3000 times at once, before the next ping is answered and the next tick begins."""
    ahead = json.dumps({"op": "publish", "topic": HUSKY, "msg": {"linear": {"x": 0.5}}}).encode()
    frame = Frame(Opcode.TEXT, ahead).serialize(mask=True)
    with socket.protocol_mutex:
        socket.socket.sendall(3000 * frame)


def say_another_type(socket: ClientConnection) -> None:
    say(socket, "publish", topic=HUSKY, msg={"data": "ahead"})


def serve(socket: ClientConnection, call: dict[str, object]) -> None:
    """Reset, which succeeds."""
    done = {"values": {"success": True, "message": ""}, "result": True}
    say(socket, "service_response", id=call["id"], service=RESET, **done)


def listen_late(socket: ClientConnection) -> None:
    """Serve a reset for a second before it subscribes; whoever calls then is too early."""
    say(socket, "advertise_service", service=RESET, type="std_srvs/Trigger")
    with suppress(TimeoutError):
        sys.exit(f"too early: {socket.recv(1.0)!r}")


def leave(socket: ClientConnection) -> None:
    socket.close()
    time.sleep(600)


def leave_a_child(_socket: ClientConnection) -> None:
    with subprocess.Popen(["sleep", "600"]):
        os._exit(3)


WRONG: dict[str, Callable[[ClientConnection], object]] = {
    "dies": lambda _: sys.exit("lost its way"),
    "is killed": lambda _: os.kill(os.getpid(), signal.SIGKILL),
    "leaves a child": leave_a_child,
    "hangs": lambda _: os.kill(os.getpid(), signal.SIGSTOP),
    "leaves": leave,
    "floods": flood,
    "says a text": lambda socket: drive(socket, "fast"),
    "says another type": say_another_type,
    "says no JSON": lambda socket: socket.send("ahead!"),
    "does nothing wrong": drive,
    "listens late": drive,
    "clings to life": lambda _: signal.signal(signal.SIGTERM, signal.SIG_IGN),
}
"""What a node does wrong when it hears for the fifth time."""


def main() -> None:
    """Do wrong."""
    what, url = sys.argv[1:]
    if what == "ends":
        sys.exit("has no map")
    with connect(url) as socket:
        if what == "is deaf":
            time.sleep(600)
        if what == "listens late":
            listen_late(socket)
        say(socket, "advertise", topic=HUSKY, type=TWIST)
        say(socket, "subscribe", topic="/husky1/odom", type="nav_msgs/Odometry")
        for n_heard, message in enumerate(socket):
            if json.loads(message)["op"] == "call_service":
                serve(socket, json.loads(message))
            elif n_heard == 4:
                WRONG[what](socket)
            else:
                drive(socket)


if __name__ == "__main__":
    main()
