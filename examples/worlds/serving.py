"""The command line of every world: joins a rosbridge server and serves until Ctrl-C."""

import argparse
import sys
import threading
from collections.abc import Callable, Sequence

import roslibpy
from bus import Bus
from robots import Obstacle, Physics, Robot, World, read_mission
from side import Side

MakePhysics = Callable[[Sequence[Robot], Sequence[Obstacle]], Physics]


def serve(name: str, make_physics: MakePhysics) -> int:
    """Serve the mission with a kind of physics and options; return the exit code."""
    options = _options(name)
    robots, obstacles = read_mission()
    world = World(robots, make_physics(robots, obstacles))
    ros = roslibpy.Ros(options.url, transport="asyncio")
    try:
        ros.run()
        problem = _serve(ros, world, options, f"uuv_sampling on {name} serves at {options.url}")
    except roslibpy.core.RosTimeoutError:
        problem = f"nobody answers at {options.url}; start one: mrsfi bridge"
    except KeyboardInterrupt:
        problem = ""
    finally:
        ros.terminate()
    if problem:
        sys.stderr.write(f"{problem}\n")
    return 1 if problem else 0


def _serve(ros: roslibpy.Ros, world: World, options: argparse.Namespace, words: str) -> str:
    """Serve until an error, and return it, or nothing at Ctrl-C."""
    ended, closed = threading.Event(), threading.Event()
    problems: list[str] = []

    def end(problem: str) -> None:
        problems.append(problem)
        ended.set()

    def close(_protocol: object) -> None:
        closed.set()
        end("the connection was lost")

    try:
        ros.on("close", close)
        Side(Bus(ros, options.prefix, options.ros, end), world).join()
        print(f"{words}; Ctrl-C ends it", flush=True)
        ended.wait()
        return problems[0]
    except KeyboardInterrupt:
        return ""
    finally:
        ros.close()
        closed.wait(5.0)


def _options(name: str) -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=f"Simulate the mission uuv_sampling on {name}.")
    parser.add_argument("--url", default="ws://127.0.0.1:9090", help="rosbridge server")
    parser.add_argument("--prefix", default="", help="before every topic and service: /world")
    parser.add_argument("--ros", type=int, choices=(1, 2), default=1, help="version of the server")
    options = parser.parse_args()
    if options.prefix and (options.prefix[0] != "/" or options.prefix[-1] == "/"):
        parser.error(f"--prefix: found {options.prefix!r}; expected a name such as /world")
    return options
