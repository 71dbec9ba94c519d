"""How long a client of ``mrsfi bridge`` waits while another says something large.

Run ``python -m benchmarks.bridge_stalls`` from the project's root. One client asks for the time
again and again. Printed is the longest time that it waited for an answer, while another client
published one message: an image of 1920 × 1080 pixels, a point cloud of 131,072 points, 8 MB of
numbers, or the same numbers to a subscriber that asks for PNG. The limit of a message is 10 MiB.
"""

import base64
import json
import threading
import time
from collections.abc import Callable
from functools import partial
from itertools import product

from websockets.sync.client import ClientConnection, connect

from benchmarks.bridge_soak import child


def said(op: str, **fields: object) -> str:
    """Return an operation."""
    return json.dumps({"op": op, **fields}, separators=(",", ":"))


NUMBERS = "std_msgs/Float64MultiArray"
IMAGE = "sensor_msgs/Image"
CLOUD = "sensor_msgs/PointCloud2"
MESSAGES = {
    IMAGE: {"height": 1080, "width": 1920, "encoding": "rgb8", "step": 5760},
    CLOUD: {"height": 128, "width": 1024, "point_step": 48, "row_step": 49152},
    NUMBERS: {"data": [1.5] * 2_000_000},
}
MESSAGES[IMAGE]["data"] = base64.b64encode(bytes(1080 * 5760)).decode()
MESSAGES[CLOUD]["data"] = base64.b64encode(bytes(128 * 49152)).decode()
ASK = json.dumps({"op": "call_service", "service": "/rosapi/get_time", "id": "t"})


def opened(url: str) -> ClientConnection:
    """Return a new client, which is told everything whole."""
    return connect(url, compression=None, max_size=None)


def publish(client: ClientConnection, text: str, kind: str, compression: str) -> None:
    """Publish a message, and wait for it."""
    client.send(said("subscribe", topic="/n", type=kind, compression=compression))
    client.send(said("advertise", topic="/n", type=kind))
    client.send(text)
    client.recv()


def longest_wait(url: str, act: Callable[[ClientConnection], None]) -> tuple[float, float]:
    """Return how long a client waits at most while another acts, and how long that takes."""
    with opened(url) as witness, opened(url) as other:
        actor = threading.Thread(target=act, args=(other,))
        begin, longest = time.perf_counter(), 0.0
        actor.start()
        while actor.is_alive():
            asked = time.perf_counter()
            witness.send(ASK)
            witness.recv()
            longest = max(longest, time.perf_counter() - asked)
            time.sleep(0.002)
        return 1000 * longest, time.perf_counter() - begin


def main() -> None:
    """Print a line for each message."""
    with child("-m", "mrsfi_runtime.cli.main", "bridge", "--port", "0") as (url, _):
        for kind, compression in (*product(MESSAGES, ["none"]), (NUMBERS, "png")):
            text = said("publish", topic="/n", msg=MESSAGES[kind])
            act = partial(publish, text=text, kind=kind, compression=compression)
            wait, took = longest_wait(url, act)
            what = f"{len(text) / 1e6:.1f} MB, {kind}, {compression}"
            print(f"{what:45} {wait:8.0f} ms waited at most, in {took:.1f} s")


if __name__ == "__main__":
    main()
