"""How fast missions fly over a rosbridge server, by client, server, and whether ticks are bundled.

Run ``python -m benchmarks.lockstep`` from the project's root after ``make install``. Each way is a
process of its own that stays open; they take turns, so that whatever slows this machine slows all
alike. Printed are ticks a second of the paper's mission, the median of some rounds, and the ratio
to roslibpy's asyncio client in the same setting. The floor is two processes that hand the bytes
of a tick to and fro on a plain socket.
"""

import argparse
import socket
import subprocess
import sys
import time
from contextlib import ExitStack
from itertools import product
from pathlib import Path
from statistics import median

from benchmarks.bridge_soak import child
from mrsfi_runtime.engine.rosbridge import RosbridgeEngine
from mrsfi_runtime.generated_code import load_code
from mrsfi_runtime.record.engine_settings import EngineSettings
from mrsfi_runtime.transport.topics import CLIENTS

MISSION = Path("generated") / "uuv_sampling"
BASE = "asyncio"
N_BYTES = 2_000
"""What travels in a tick, about."""


def fly(client: str, url: str, is_bundled: bool) -> None:
    """Fly once for each line that is said, and answer with ticks a second."""
    code = load_code(MISSION)
    settings = EngineSettings("rosbridge", url=url or None, client=client, is_bundled=is_bundled)
    with RosbridgeEngine(code, 1, settings) as engine:
        for _ in sys.stdin:
            begin = time.perf_counter()
            engine.evaluate(())
            print(code.mission.duration / (time.perf_counter() - begin), flush=True)


def exchange() -> None:
    """Hand bytes to and fro with another process for each line that is said."""
    with socket.create_server(("127.0.0.1", 0)) as server:
        port = server.getsockname()[1]
        words = [sys.executable, "-c", _ECHO, str(port), str(N_BYTES)]
        with subprocess.Popen(words), server.accept()[0] as side:
            side.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            for _ in sys.stdin:
                begin = time.perf_counter()
                for _ in range(1000):
                    side.sendall(bytes(N_BYTES))
                    side.recv(N_BYTES, socket.MSG_WAITALL)
                print(1000 / (time.perf_counter() - begin), flush=True)


_ECHO = """
import socket, sys
side = socket.create_connection(("127.0.0.1", int(sys.argv[1])))
side.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
while content := side.recv(int(sys.argv[2]), socket.MSG_WAITALL):
    side.sendall(content)
"""


def main() -> None:
    """Print a line for each way."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--one", nargs="*", help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.one is not None:
        client, url, bundled = arguments.one or ("", "", "")
        return fly(client, url, bool(bundled)) if client else exchange()
    ways = list(product(("embedded", "separate"), ("messages", "bundles"), CLIENTS))
    with ExitStack() as opened:

        def words(server: str, what: str, client: str) -> list[str]:
            """Return the arguments of a way, with a server of its own, as topics are the same."""
            bridge = ("-m", "mrsfi_runtime.cli.main", "bridge", "--port", "0")
            url = opened.enter_context(child(*bridge))[0] if server == "separate" else ""
            return ["--one", client, url, "1" * (what == "bundles")]

        processes = [
            opened.enter_context(
                subprocess.Popen(
                    [sys.executable, "-m", "benchmarks.lockstep", *each],
                    stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, bufsize=1,
                )
            )
            for each in (['--one'], *(words(*way) for way in ways))
        ]  # fmt: skip
        found: list[list[float]] = [[] for _ in processes]
        for _ in range(arguments.rounds + 1):
            for process, rates in zip(processes, found, strict=True):
                process.stdin.write("\n")
                rates.append(float(process.stdout.readline()))
        for process in processes:
            process.stdin.close()
    floor, *rates = (median(each[1:]) for each in found)  # the first one warms
    print(f"bare socket: {floor:,.0f} rounds a second")
    by_way = dict(zip(ways, rates, strict=True))
    for (server, what, client), rate in by_way.items():
        ratio = rate / by_way[server, what, BASE]
        print(f"{server:9} {what:9} {client:8} {rate:7,.0f} ticks/s {ratio:6.2f}")
    return None


if __name__ == "__main__":
    main()
