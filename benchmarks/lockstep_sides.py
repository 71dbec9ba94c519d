"""The two sides of a lock-step that does nothing but exchange messages, each in a process.

Fifteen topics a tick as three robots with two sensors each publish them, then one reply. Every
message carries its tick; one that is lost, doubled or out of order ends the run.

Run as ``python -m benchmarks.lockstep_sides SIDE [URL CLIENT [SECONDS]]`` by ``lockstep.py``.
"""

import json
import os
import sys
import time
from collections.abc import Callable
from contextlib import ExitStack
from functools import partial
from threading import Event
from typing import Any, Protocol

import roslibpy

from benchmarks.prepared import PreparedTicks
from benchmarks.relay import Relay
from mrsfi_bridge.embedded import EmbeddedBridge, LocalClient

ROBOTS = ("r1", "r2", "r3")
TOPICS = tuple(
    (f"/{robot}/{name}", type_name)
    for robot in ROBOTS
    for name, type_name in (
        ("position", "geometry_msgs/Point"),
        ("speed", "std_msgs/Float64"),
        ("energy", "std_msgs/Float64"),
        ("s1/samples", "std_msgs/Int64"),
        ("s2/samples", "std_msgs/Int64"),
    )
)
REPLY = ("/reply", "std_msgs/Int64")
WARM_UP = 0.3
"""Seconds before ticks count."""
N_PREPARED = 20_000
"""Ticks encoded before a client alone is measured."""


def messages(tick: int) -> list[tuple[str, dict[str, Any]]]:
    """Return topic and message of all that is published in a tick."""
    values: dict[str, dict[str, Any]] = {
        "geometry_msgs/Point": {"x": float(tick), "y": -123.456789, "z": 1.0},
        "std_msgs/Float64": {"data": float(tick)},
        "std_msgs/Int64": {"data": tick},
    }
    return [(name, values[type_name]) for name, type_name in TOPICS]


class Bus(Protocol):
    """What a side needs of a bus."""

    def publish(self, topic: str, message: dict[str, Any]) -> None:
        """Send a message."""

    def subscribe(self, topic: str, callback: Callable[[dict[str, Any]], None]) -> None:
        """Have a function receive the messages of a topic."""


class RoslibpyBus:
    """An unmodified roslibpy client."""

    def __init__(self, url: str, client: str) -> None:
        self._ros = roslibpy.Ros(url, transport=client)
        self._ros.run()
        self._publishers: dict[str, Any] = {}

    def publish(self, topic: str, message: dict[str, Any]) -> None:
        """Send a message."""
        publisher = self._publishers.get(topic)
        if publisher is None:
            publisher = roslibpy.Topic(self._ros, topic, dict((*TOPICS, REPLY))[topic])
            self._publishers[topic] = publisher
        publisher.publish(message)

    def subscribe(self, topic: str, callback: Callable[[dict[str, Any]], None]) -> None:
        """Have a function receive the messages of a topic."""
        type_name = dict((*TOPICS, REPLY))[topic]
        roslibpy.Topic(self._ros, topic, type_name).subscribe(callback)


class BridgeBus:
    """The embedded bridge, seen from within."""

    def __init__(self, client: LocalClient) -> None:
        self._client = client
        for name, type_name in TOPICS:
            client.advertise(name, type_name)

    def publish(self, topic: str, message: dict[str, Any]) -> None:
        """Send a message."""
        self._client.publish(topic, message)

    def subscribe(self, topic: str, callback: Callable[[dict[str, Any]], None]) -> None:
        """Have a function receive the messages of a topic."""
        self._client.subscribe(topic, dict((REPLY,))[topic], callback)


class Simulation:
    """Publishes the next tick when the reply to the one before has come."""

    def __init__(self, bus: Bus) -> None:
        self._bus = bus
        self._tick = -1
        bus.subscribe(REPLY[0], self._on_reply)

    def _on_reply(self, message: dict[str, Any]) -> None:
        tick = message["data"]
        if tick == -1 and self._tick >= 0:
            return  # the CI greets until the first tick comes
        if tick != self._tick:
            _end(f"the simulation got reply {tick}; expected {self._tick}")
        self._tick += 1
        for name, said in messages(self._tick):
            self._bus.publish(name, said)


class Intelligence:
    """Replies to every tick, and counts ticks for some seconds after the warm-up."""

    def __init__(self, bus: Bus, seconds: float) -> None:
        self._bus = bus
        self._seconds = seconds
        self._tick = 0
        self._n_received = 0
        self._begin = 0.0
        self._first_tick = 0
        self._is_counting = False
        self.rate = 0.0
        self.ended = Event()
        for index, (name, _) in enumerate(TOPICS):
            bus.subscribe(name, partial(self._on_message, index))

    def greet(self) -> None:
        """Begin; again and again, because the simulation may not listen yet."""
        while self._tick == 0 and self._n_received == 0:
            self._bus.publish(REPLY[0], {"data": -1})
            time.sleep(0.2)

    def _on_message(self, index: int, message: dict[str, Any]) -> None:
        value = message["x"] if "x" in message else message["data"]
        if index != self._n_received or value != self._tick:
            _end(f"topic {index} of tick {value}; expected {self._n_received} of {self._tick}")
        self._n_received += 1
        if self._n_received == len(TOPICS) and not self.ended.is_set():
            self._n_received = 0
            self._measure()
            self._tick += 1
            self._bus.publish(REPLY[0], {"data": self._tick - 1})

    def _measure(self) -> None:
        now = time.perf_counter()
        if self._tick == 0:
            self._begin = now
        elapsed = now - self._begin
        if not self._is_counting and elapsed > WARM_UP:
            self._is_counting, self._begin, self._first_tick = True, now, self._tick
        elif self._is_counting and elapsed > self._seconds:
            self.rate = (self._tick - self._first_tick) / elapsed
            self.ended.set()


def _end(problem: str) -> None:
    """End the process from whatever thread: a benchmark that lost messages measures nothing."""
    _say(problem=problem)
    os._exit(1)


def _say(**said: str | float) -> None:
    print(json.dumps(said), flush=True)


def _joined(bridge: EmbeddedBridge) -> EmbeddedBridge:
    """Let the simulation join a bridge in the thread of it."""
    is_joined = Event()

    def join() -> None:
        Simulation(BridgeBus(bridge.local_client()))
        is_joined.set()

    bridge.call_soon(join)
    is_joined.wait()
    return bridge


def main(side: str, url: str = "", client: str = "", seconds: str = "0") -> None:
    """Be one side until the measurement or the parent's patience ends."""
    if side == "ci":
        intelligence = Intelligence(RoslibpyBus(url, client), float(seconds))
        intelligence.greet()
        intelligence.ended.wait()
        _say(rate=intelligence.rate)
        return
    with ExitStack() as stack:
        if side == "simulation":
            Simulation(RoslibpyBus(url, client))
        elif side == "prepared":
            url = stack.enter_context(PreparedTicks(messages, N_PREPARED)).url
        elif side == "embedded":
            url = _joined(stack.enter_context(EmbeddedBridge())).url
        else:
            relay = stack.enter_context(Relay())
            url = relay.url
            if side == "embedded-relay":
                Simulation(relay)
        _say(url=url)
        sys.stdin.read()


if __name__ == "__main__":
    main(*sys.argv[1:])
