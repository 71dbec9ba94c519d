"""Starts and ends a team's node, in a process between it and the engine that both die with.

Run as ``python -m mrsfi_runtime.engine.node_keeper`` it finds a connection to the engine's process,
starts and ends nodes as that says, and says there how they ended. When the other end of the
connection is gone, however its process came to that, so is the node, with all that it started.
"""

import os
import signal
import sys
from collections import deque
from contextlib import suppress
from multiprocessing.connection import Connection, wait
from subprocess import DEVNULL, PIPE, STDOUT, Popen, TimeoutExpired
from threading import Thread

_GRACE = 1.0
"""Seconds that a node has to end when it is told to."""

_LOOK_S = 0.05
_LAST_LINES = 5


class _Child:
    """A node that was started, and the last lines that it wrote."""

    def __init__(self, words: list[str]) -> None:
        self.process = Popen(
            words, stdin=DEVNULL, stdout=PIPE, stderr=STDOUT, start_new_session=True
        )
        self._lines: deque[bytes] = deque(maxlen=_LAST_LINES)
        self._reader = Thread(target=self._read, daemon=True)
        self._reader.start()

    def _read(self) -> None:
        assert self.process.stdout is not None
        for line in self.process.stdout:
            self._lines.append(line[:500])

    def end(self) -> None:
        """End the node and all that it started."""
        for number in (signal.SIGTERM, signal.SIGKILL):
            with suppress(ProcessLookupError, PermissionError):
                os.killpg(self.process.pid, number)
            with suppress(TimeoutExpired):
                self.process.wait(_GRACE)

    def last_words(self) -> str:
        """Return how it ended, and what it wrote last."""
        self._reader.join(_GRACE)
        code = self.process.returncode
        how = f"signal {signal.Signals(-code).name}" if code < 0 else f"exit code {code}"
        lines = [line.decode(errors="replace").strip() for line in self._lines]
        said = " / ".join(line for line in lines if line)
        return f"{how}{': ' if said else ''}{said}"


class Keeper:
    """Keeps one node at a time, as a connection says."""

    def __init__(self, connection: Connection) -> None:
        self._connection = connection
        self._child: _Child | None = None

    def serve(self) -> None:
        """Start what words name that come, or end what runs if none do; until nobody speaks."""
        with suppress(EOFError, OSError):
            while True:
                self._look()
                if wait([self._connection], None if self._child is None else _LOOK_S):
                    self._change(self._connection.recv())
        self._end()

    def _look(self) -> None:
        """Tell how the node ended, if it has."""
        child = self._child
        if child is not None and child.process.poll() is not None:
            self._end()  # what it started, too
            self._connection.send(("ended", child.last_words()))

    def _change(self, words: list[str]) -> None:
        self._end()
        try:
            self._child = _Child(words) if words else None
        except OSError as error:
            self._connection.send(("failed", f"{words[0]}: {error.strerror}"))
            return
        self._connection.send(("done", str(self._child.process.pid) if self._child else ""))

    def _end(self) -> None:
        child, self._child = self._child, None
        if child is not None:
            child.end()


if __name__ == "__main__":
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    Keeper(Connection(int(sys.argv[1]))).serve()
