"""How long a client of ``mrsfi bridge`` waits while another says something large.

Run ``python -m benchmarks.bridge_stalls`` from the project's root. One client asks for the time
again and again; printed is the longest that it waited for an answer, while another one published
8 MB of numbers, the same for who wants it as PNG, 170,000 messages in one frame, or called a
service with 8 MB of numbers, which answered with as many.
"""

import json
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory

from websockets.sync.client import ClientConnection, connect

from benchmarks.bridge_soak import child


def said(op: str, **fields: object) -> str:
    """Return an operation."""
    return json.dumps({"op": op, **fields}, separators=(",", ":"))


AIM_MS = 100
NUMBERS = "std_msgs/Float64MultiArray"
NUMBERS_SAID = said("publish", topic="/n", msg={"data": [1.5] * 2_000_000})
MANY_SAID = said("publish", topic="/m", msg={"data": 1}) * 170_000
CALL_SAID = said("call_service", service="/s", args={"data": [1.5] * 2_000_000})
ANSWER_SAID = said("service_response", id="%s", service="/s", values={"data": [1.5] * 2_000_000})
ASK = json.dumps({"op": "call_service", "service": "/rosapi/get_time", "id": "t"})


def opened(url: str) -> ClientConnection:
    """Return a new client, which is told everything whole."""
    return connect(url, compression=None, max_size=None)


def numbers(client: ClientConnection, compression: str = "none") -> None:
    """Publish 8 MB of numbers, and wait for them."""
    client.send(said("subscribe", topic="/n", type=NUMBERS, compression=compression))
    client.send(said("advertise", topic="/n", type=NUMBERS))
    client.send(NUMBERS_SAID)
    client.recv()


def many(client: ClientConnection) -> None:
    """Publish 170,000 messages in one frame, and wait for the last."""
    client.send(said("advertise", topic="/m", type="std_msgs/Int32"))
    client.send(MANY_SAID)
    client.send(ASK)
    client.recv()


def serve(client: ClientConnection) -> None:
    """Call a service that the client itself provides with 8 MB of numbers, and answer with them."""
    client.send(said("advertise_service", service="/s", type="soak/Numbers"))
    client.send(CALL_SAID)
    start = client.recv().partition('"id":"')[2]
    client.send(ANSWER_SAID % start.partition('"')[0])
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


def main() -> int:
    """Print a line for each; return 1 if one is above the aim."""
    acts = {
        "8 MB of numbers": numbers,
        "8 MB of numbers as PNG": lambda client: numbers(client, "png"),
        "170,000 messages in a frame": many,
        "8 MB to a service and back": serve,
    }
    waits = []
    words = ("-m", "mrsfi_runtime.cli.main", "bridge", "--port", "0", "--types")
    with TemporaryDirectory() as folder:
        path = Path(folder, "soak", "srv", "Numbers.srv")
        path.parent.mkdir(parents=True)
        path.write_text("float64[] data\n---\nfloat64[] data\n", encoding="utf-8")
        with child(*words, folder) as (url, _):
            for what, act in acts.items():
                wait, took = longest_wait(url, act)
                print(f"{what:28} {wait:8.0f} ms waited at most, in {took:.1f} s")
                waits.append(wait)
    return int(max(waits) > AIM_MS)


if __name__ == "__main__":
    sys.exit(main())
