"""When a node has answered a tick: by a message, by pings, or when its time is over."""

from collections.abc import Callable
from time import monotonic
from typing import TypeAlias

from mrsfi_runtime.transport.topics import NodeTransport

ANSWER, BARRIER = "answer", "barrier"
"""The node says so, or it answers pings behind all that it was told."""

PACES = (ANSWER, BARRIER)

Barrier: TypeAlias = Callable[[Callable[[], None]], None]
"""Calls a function when the clients of a server have answered pings behind what they were told."""


class Pace:
    """``answer``, ``barrier``, or a rate in ticks a second, at which nothing is waited for."""

    def __init__(self, kind: str, barrier: Barrier | None = None) -> None:
        self.kind = kind
        self._barrier = barrier
        self._start = 0.0

    @property
    def is_free(self) -> bool:
        """Whether the node runs by its own clock, so that no flight repeats itself for sure."""
        return self.kind not in PACES

    def begin(self) -> None:
        """Begin a flight: tick 0 begins now."""
        self._start = monotonic()

    def wait(self, transport: NodeTransport, tick: int, then: Callable[[], None]) -> None:
        """Call a function when a tick is over of which the node was told, unless it says so."""
        if self.is_free:
            due = self._start + (tick + 1) / float(self.kind)
            transport.call_later(max(due - monotonic(), 0.0), then)
        elif self._barrier is not None and self.kind == BARRIER:
            self._barrier(then)

    def awaited(self, answer: str) -> str:
        """Return what is waited for, in words."""
        return f"a message on {answer}" if self.kind == ANSWER else "answers to pings"
