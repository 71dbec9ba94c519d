"""What a tick costs with a team's own node as the collective intelligence, by its pace.

Run ``python -m benchmarks.injector`` from the project's root after ``make install`` and
``pip install -e '.[ros2]'``. The nodes are those of the tests: the generated reactions behind a
socket or on DDS, reset by a service. The server is embedded, or a process. Each way is a
process of its own that stays open; they take turns, so that whatever slows this machine slows all
alike. Printed are ticks a second of the paper's mission, the median of some rounds, and how many
times as long as a tick of the two generated sides over the default client each takes.
"""

import argparse
import subprocess
import sys
import time
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from statistics import median

from mrsfi_runtime.cosimulation.bus_topics import ANSWER, BARRIER
from mrsfi_runtime.engine.opening import open_engine
from mrsfi_runtime.generated_code import load_code
from mrsfi_runtime.record.engine_settings import (
    BUILT_IN,
    INJECTOR,
    ROS2,
    SERVICE,
    EngineSettings,
)

MISSION = Path("generated") / "uuv_sampling"
NODE = f"{sys.executable} -m tests.support.standin_node {MISSION} {{url}} 1 {{seed}}"
ROS2_NODE = f"{sys.executable} -m tests.support.ros2_node {MISSION} {{domain}} {{seed}}"
WAYS = ("two sides", "answer", "barrier", "answer at a server", "ros2 answer", "ros2 barrier")


def fly(way: str) -> None:
    """Fly once for each line that is said, and answer with ticks a second."""
    code = load_code(MISSION)
    settings = EngineSettings("rosbridge")
    if way != WAYS[0]:
        pace = BARRIER if BARRIER in way else ANSWER
        settings = replace(settings, side=INJECTOR, node=NODE, node_pace=pace, node_reset=SERVICE)
    if way.startswith(ROS2):
        settings = replace(settings, name=ROS2, node=ROS2_NODE)
    with ExitStack() as opened:
        if way == WAYS[3]:
            settings = replace(settings, url=server(opened), world=BUILT_IN)
        engine = opened.enter_context(open_engine(settings, code, 1))
        for _ in sys.stdin:
            begin = time.perf_counter()
            engine.evaluate(())
            print(code.mission.duration / (time.perf_counter() - begin), flush=True)


def server(opened: ExitStack) -> str:
    """Start a server in a process, and return its URL."""
    words = [sys.executable, "-m", "mrsfi_bridge", "--port", "0"]
    process = opened.enter_context(subprocess.Popen(words, stdout=subprocess.PIPE, text=True))
    opened.callback(process.terminate)
    return process.stdout.readline().strip()


def main() -> None:
    """Print a line for each way."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--rounds", type=int, default=9)
    parser.add_argument("--one", choices=WAYS, help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.one is not None:
        return fly(arguments.one)
    with ExitStack() as opened:
        processes = [
            opened.enter_context(
                subprocess.Popen(
                    [sys.executable, "-m", "benchmarks.injector", "--one", way],
                    stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, bufsize=1,
                )
            )
            for way in WAYS
        ]  # fmt: skip
        found: list[list[float]] = [[] for _ in WAYS]
        for _ in range(arguments.rounds + 1):
            for process, rates in zip(processes, found, strict=True):
                process.stdin.write("\n")
                rates.append(float(process.stdout.readline()))
        for process in processes:
            process.stdin.close()
    rates = [median(each[1:]) for each in found]  # the first one warms
    for way, rate in zip(WAYS, rates, strict=True):
        print(f"{way:18} {rate:7,.0f} ticks/s {rates[0] / rate:6.2f}")
    return None


if __name__ == "__main__":
    main()
