"""The command line of every world: joins a rosbridge server and serves until it is ended."""

import argparse
import signal
import sys
import threading
from contextlib import closing
from pathlib import Path
from types import FrameType
from typing import NoReturn

import roslibpy
from bus import Bus
from mission import read_mission
from robots import Physics, World, WorldError
from side import Side


def serve(name: str, physics: type[Physics]) -> int:
    """Serve a mission with a kind of physics and its options; return the exit code.

    Ctrl-C and SIGTERM end it with 0, an error with 1, and what cannot be flown here with 2.
    However it ends, except by SIGKILL, ``close`` of the physics is called.
    """
    options = _options(name, physics)
    signal.signal(signal.SIGTERM, _interrupt)
    try:
        mission = read_mission(options.mission)
        words = f"{mission.name} on {name} serves at {options.url}; Ctrl-C ends it"
        with closing(physics(mission, options)) as made:
            problem, code = _connect(World(mission.robots, made), options, words), 1
    except WorldError as error:
        problem, code = str(error), 2
    except KeyboardInterrupt:
        problem = ""
    if problem:
        sys.stderr.write(f"{problem}\n")
    return code if problem else 0


def _interrupt(_signal: int, _frame: FrameType | None) -> NoReturn:
    raise KeyboardInterrupt


def _connect(world: World, options: argparse.Namespace, words: str) -> str:
    """Serve at a server until an error, and return it, or nothing at Ctrl-C."""
    ros = roslibpy.Ros(options.url, transport="asyncio")
    try:
        ros.run()
        return _serve(ros, world, options, words)
    except roslibpy.core.RosTimeoutError:
        return f"nobody answers at {options.url}; start one: mrsfi bridge"
    finally:
        ros.terminate()


def _serve(ros: roslibpy.Ros, world: World, options: argparse.Namespace, words: str) -> str:
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
        print(words, flush=True)
        ended.wait()
        return problems[0]
    except KeyboardInterrupt:
        return ""
    finally:
        ros.close()
        closed.wait(5.0)


def _options(name: str, physics: type[Physics]) -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=f"Simulate a mission on {name}.")
    parser.add_argument(
        "--mission", type=Path, required=True, help="its mission.xmi, or the folder of that file"
    )
    parser.add_argument("--url", default="ws://127.0.0.1:9090", help="rosbridge server")
    parser.add_argument("--prefix", default="", help="before every topic and service: /world")
    parser.add_argument("--ros", type=int, choices=(1, 2), default=1, help="version of the server")
    physics.add_options(parser.add_argument_group(f"of {name}"))
    options = parser.parse_args()
    if options.prefix and (options.prefix[0] != "/" or options.prefix[-1] == "/"):
        parser.error(f"--prefix: found {options.prefix!r}; expected a name such as /world")
    return options
