"""Flights over rosbridge for tests, and a relay that delays and tampers with what passes.

Run ``python -m tests.support.rosbridge CLIENT MISSION DURATION URL ROS SEED …`` to fly
one random specification per seed in a process of its own: a process has one kind of client only.
"""

import asyncio
import json
import logging
import os
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from random import Random
from typing import Self

from websockets.asyncio.client import connect
from websockets.asyncio.server import ServerConnection, serve
from websockets.exceptions import ConnectionClosed

from mrsfi_runtime.engine.flights import Engine, ReferenceEngine
from mrsfi_runtime.engine.rosbridge import RosbridgeEngine
from mrsfi_runtime.generated_code import MissionCode
from mrsfi_runtime.record.engine_settings import CI, EngineSettings
from tests.support.cli import command_line
from tests.support.trace import TraceDigest
from tests.support.tree import ROOT
from tests.support.world import code_of, specification

FLIGHT_SEED = 11

_SILENT = logging.getLogger("tests.relay")
_SILENT.disabled = True
_OPTIONS = {"compression": None, "max_size": None, "ping_interval": None, "logger": _SILENT}

Tamper = Callable[[str], list[str]]
"""What becomes of a frame."""


def digests(engine: Engine, seeds: Sequence[int]) -> list[list[str]]:
    """Return for each seed the digest of the outcome and that of every tick."""
    found = []
    for seed in seeds:
        trace = TraceDigest()
        outcome = engine.evaluate(specification(engine.code, seed), observer=trace)
        found.append([outcome.digest, trace.hexdigest()])
    return found


def reference_digests(code: MissionCode, seeds: Sequence[int]) -> list[list[str]]:
    """Return what ``digests`` must return for any engine."""
    return digests(ReferenceEngine(code, FLIGHT_SEED), seeds)


def digests_apart(
    client: str,
    mission: str,
    duration: int,
    seeds: Sequence[int],
    url: str,
    ros: int,
) -> list[list[str]]:
    """Return the digests of flights with the simulation at a server, in a process of its own."""
    words = [client, mission, str(duration), url, str(ros), *map(str, seeds)]
    done = subprocess.run(
        [sys.executable, "-W", "error", "-m", __name__, *words],
        check=False,
        cwd=ROOT,
        capture_output=True,
        encoding="utf-8",
        timeout=240,
    )
    assert done.returncode == 0, done.stderr
    assert done.stderr == ""
    found: list[list[str]] = json.loads(done.stdout)
    return found


class Relay:
    """A websocket relay in a thread: order is kept, unless tamper or scatter break it.

    Parameters
    ----------
    upstream
        The server behind it.
    to_server
        What becomes of the frames to the server.
    scatter
        Greatest delay of a message in seconds, with order kept within its topic only, as
        the genuine rosbridge server does.
    """

    def __init__(
        self,
        upstream: str,
        *,
        to_server: Tamper | None = None,
        scatter: float = 0.0,
    ) -> None:
        self._upstream = upstream
        self._to_server = to_server or (lambda frame: [frame])
        self._scatter = scatter
        self._random = Random(1)
        self._ready = threading.Event()
        self._loop: asyncio.AbstractEventLoop | None = None
        self._stop: asyncio.Event | None = None
        self._thread = threading.Thread(target=lambda: asyncio.run(self._serve()))
        self.url = ""

    def __enter__(self) -> Self:
        self._thread.start()
        assert self._ready.wait(10)
        return self

    def __exit__(self, *_error: object) -> None:
        if self._loop is not None and self._stop is not None:
            self._loop.call_soon_threadsafe(self._stop.set)
        self._thread.join()

    async def _serve(self) -> None:
        self._loop, self._stop = asyncio.get_running_loop(), asyncio.Event()
        async with serve(self._join, "127.0.0.1", 0, **_OPTIONS) as server:
            self.url = f"ws://127.0.0.1:{server.sockets[0].getsockname()[1]}"
            self._ready.set()
            await self._stop.wait()

    async def _join(self, client: ServerConnection) -> None:
        async with connect(self._upstream, **_OPTIONS) as server:
            await asyncio.gather(
                self._pump(client, server, self._to_server),
                self._pump(server, client, lambda frame: [frame]),
            )

    async def _pump(self, source, sink, tamper: Tamper) -> None:
        """Pass frames on, each after its delay, in order or in that of its topic."""
        lanes: dict[str, Lane] = {}
        with suppress(ConnectionClosed):
            async for frame in source:
                for passed in tamper(frame):
                    topic = _topic(passed) if self._scatter else ""
                    if topic not in lanes:
                        lanes[topic] = Lane(sink)
                    lanes[topic].put(passed, self._random.uniform(0.0, self._scatter))
        for lane in lanes.values():
            await lane.end()
        await sink.close()


class Lane:
    """Frames on their way to a connection, in order, each after its delay."""

    def __init__(self, sink) -> None:
        self._sink = sink
        self._queue: asyncio.Queue[tuple[float, str] | None] = asyncio.Queue()
        self._loop = asyncio.get_running_loop()
        self._task = asyncio.create_task(self._send())

    def put(self, frame: str, delay: float) -> None:
        """Have a frame sent so many seconds later, or after those before it."""
        self._queue.put_nowait((self._loop.time() + delay, frame))

    async def end(self) -> None:
        """Wait until all is sent."""
        self._queue.put_nowait(None)
        with suppress(ConnectionClosed):
            await self._task

    async def _send(self) -> None:
        while (item := await self._queue.get()) is not None:
            due, frame = item
            if due > self._loop.time():
                await asyncio.sleep(due - self._loop.time())
            await self._sink.send(frame)


def _topic(frame: str) -> str:
    """Return the topic that a frame carries a message of; all others count as one."""
    message = json.loads(frame)
    return message["topic"] if message["op"] == "publish" else ""


@contextmanager
def process(
    *words: str | Path, cwd: Path = ROOT, program: Sequence[str] = (), **environment: str
) -> Iterator[subprocess.Popen[str]]:
    """Run ``mrsfi``, or another program, in a process that ends with the test."""
    running = subprocess.Popen(
        [*program, *words] if program else command_line(*words),
        cwd=cwd,
        env={**os.environ, **environment},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        encoding="utf-8",
        start_new_session=True,
    )
    try:
        yield running
    finally:
        running.kill()
        running.communicate()


def main() -> None:
    """Print the digests of flights over rosbridge as JSON."""
    client, mission, duration, url, ros, *seeds = sys.argv[1:]
    code = code_of(mission, int(duration))
    settings = EngineSettings(url=url, ros=int(ros), client=client, side=CI)
    with RosbridgeEngine(code, FLIGHT_SEED, settings) as engine:
        sys.stdout.write(json.dumps(digests(engine, [int(seed) for seed in seeds])))


if __name__ == "__main__":
    main()
