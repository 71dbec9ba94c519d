"""A barrier between what clients are told and what they say to it.

A client that works off what it hears in one thread answers a ping after all that was sent before;
by the second pong it has also sent what it had to say. Measured for roslibpy, asyncio and Twisted,
and for roslib on Node (docs/node.md).
"""

from asyncio import AbstractEventLoop
from collections.abc import Callable
from itertools import count
from typing import Protocol

ROUNDS = 2
"""Pings that go to each client, the second when the first is answered."""


class Pinged(Protocol):
    """A client that can be pinged."""

    def ping(self, content: bytes) -> None:
        """Ping it, behind all that it was sent."""


class Barriers:
    """Barriers of all clients of a server; ``is_idle`` says whether all that was said went out."""

    def __init__(self, loop: AbstractEventLoop, is_idle: Callable[[], bool]) -> None:
        self._loop = loop
        self._is_idle = is_idle
        self._numbers = count(1)
        self._open: dict[bytes, dict[Pinged, Callable[[], None]]] = {}

    def begin(
        self, clients: Callable[[], list[Pinged]], then: Callable[[], None], rounds: int = ROUNDS
    ) -> None:
        """Call a function when those who are clients have answered so many pings, one by one.

        While there is no client, nobody has answered.
        """
        if not self._is_idle():
            self._loop.call_soon(self.begin, clients, then, rounds)
            return
        pinged = clients()
        if not pinged:
            return
        if not rounds:
            then()
            return

        def answered() -> None:
            self.begin(clients, then, rounds - 1)

        content = next(self._numbers).to_bytes(8, "big")
        self._open[content] = dict.fromkeys(pinged, answered)
        for client in pinged:
            client.ping(content)

    def pong(self, client: Pinged, content: bytes) -> None:
        """Take what a client answered to a ping."""
        if client in self._open.get(content, {}):
            self._answered(content, client)

    def gone(self, client: Pinged) -> None:
        """Wait no more for a client that has left."""
        for content in tuple(self._open):
            if client in self._open.get(content, {}):
                self._answered(content, client)

    def _answered(self, content: bytes, client: Pinged) -> None:
        waiting = self._open[content]
        answered = waiting.pop(client)
        if not waiting:
            del self._open[content]
            answered()
