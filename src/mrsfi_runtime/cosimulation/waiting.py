"""How far a run has come: told by the thread of the callbacks, awaited by the main thread."""

from collections.abc import Callable
from dataclasses import dataclass
from threading import Event
from time import monotonic
from typing import Any

from mrsfi_runtime.errors import MrsfiError

_LOOK = 0.1


@dataclass(frozen=True, slots=True)
class Patience:
    """How many seconds one side waits for the other's part of a tick, and before tick 0."""

    tick: float = 10.0
    handshake: float = 30.0


class Completion:
    """What one thread brings to its end, good or bad, and another waits for; it goes by steps.

    ``result`` is what came of it, once it has ended well.
    """

    def __init__(self) -> None:
        self.result: Any = None
        self._n_steps = 0
        self._ended = Event()
        self._failure: Exception | None = None

    def advance(self) -> None:
        """Note a step."""
        self._n_steps += 1

    def end(self, result: object = None) -> None:
        """Note that all is done, and what came of it."""
        self.result = result
        self._ended.set()

    def fail(self, error: Exception) -> None:
        """Note why it cannot go on; the first reason counts."""
        if self._failure is None and not self._ended.is_set():
            self._failure = error
            self._ended.set()

    def wait(self, overdue: Callable[[float], MrsfiError | None]) -> None:
        """Wait for the end, and raise the failure, whoever noted it.

        ``overdue`` gets the seconds since the last step; what it returns, if anything, is raised.
        """
        n_steps, since = self._n_steps, monotonic()
        while not self._ended.wait(_LOOK):
            if n_steps != self._n_steps:
                n_steps, since = self._n_steps, monotonic()
                continue
            error = overdue(monotonic() - since)
            if error is not None:
                raise error
        if self._failure is not None:
            raise self._failure
