"""Programs that are started here, a node or a simulation, and end with this process.

A keeper process starts and ends a program. Run as this module, ``Keeper`` reads from a connection
which program to start or end, and reports how programs ended. When the connection closes, for any
reason, the keeper ends the program and all processes that it started. ``KeptProcess`` is this side
of it.
"""

import os
import shlex
import signal
import sys
from collections import deque
from collections.abc import Mapping
from contextlib import suppress
from multiprocessing import Pipe
from multiprocessing.connection import Connection, wait
from subprocess import DEVNULL, PIPE, STDOUT, Popen, TimeoutExpired
from threading import Thread
from typing import TypeAlias

from mrsfi_runtime.errors import TransportClosed, TransportError, UsageError

_GRACE = 1.0
"""Seconds that a program has to end after a signal."""


class _Child:
    """A program that was started, and the last lines that it wrote."""

    def __init__(self, words: list[str]) -> None:
        self.process = Popen(
            words, stdin=DEVNULL, stdout=PIPE, stderr=STDOUT, start_new_session=True
        )
        self._lines: deque[bytes] = deque(maxlen=5)
        self._reader = Thread(target=self._read, daemon=True)
        self._reader.start()

    def _read(self) -> None:
        assert self.process.stdout is not None
        for line in self.process.stdout:
            self._lines.append(line[:500])

    def end(self) -> None:
        """End the program and all processes that it started."""
        for number in (signal.SIGTERM, signal.SIGKILL):
            with suppress(ProcessLookupError, PermissionError):
                os.killpg(self.process.pid, number)
            with suppress(TimeoutExpired):
                self.process.wait(_GRACE)

    def last_words(self) -> str:
        """Return how it ended, and what it wrote last."""
        self._reader.join(_GRACE)
        how = ending(self.process, _GRACE)
        lines = [line.decode(errors="replace").strip() for line in self._lines]
        output = " / ".join(line for line in lines if line)
        return f"{how}{': ' if output else ''}{output}"


def ending(process: "Popen[bytes]", seconds: float) -> str:
    """Return how a process ended; kill it if it does not end in time."""
    try:
        code = process.wait(seconds)
    except TimeoutExpired:
        process.kill()
        code = process.wait()
    return f"signal {signal.Signals(-code).name}" if code < 0 else f"exit code {code}"


class Keeper:
    """Starts and ends programs, one at a time, as a connection requests."""

    def __init__(self, connection: Connection) -> None:
        self._connection = connection
        self._child: _Child | None = None

    def serve(self) -> None:
        """Start each command received, an empty one only ends the program; until disconnected."""
        with suppress(EOFError, OSError):
            while True:
                child = self._child
                if child is not None and child.process.poll() is not None:
                    self._end()  # the processes that it started, too
                    self._connection.send(("ended", child.last_words()))
                if wait([self._connection], None if self._child is None else 0.05):
                    self._change(self._connection.recv())
        self._end()

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


NODE, WORLD = "--node", "--world"
_NAMES = {NODE: "the node", WORLD: "the simulation"}
"""What an option starts, in words."""


def child_of(module: str, stdout: int | None = None) -> tuple["Popen[bytes]", Connection]:
    """Run a module in a process, with one end of a connection; return it, and the other end."""
    connection, other_end = Pipe()
    with other_end:
        process = Popen(
            [sys.executable, "-m", module, str(other_end.fileno())],
            pass_fds=[other_end.fileno()],
            stdin=DEVNULL,
            start_new_session=True,  # Ctrl-C reaches this process only, which ends that one
            stdout=stdout,
        )
    return process, connection


Places: TypeAlias = Mapping[str, str]
"""What a command may say of where a program finds its peers, by name in braces."""


def places_of(url: str) -> Places:
    """Return what a command may say of a server: its URL, or its host and port."""
    host, _, port = url.partition("://")[2].partition("/")[0].rpartition(":")
    return {"{url}": url, "{host}": host, "{port}": port}


class KeptProcess:
    """A program that dies with this process; ``pid`` is 0 while it does not run.

    ``option`` gives the ``command``, in which ``{seed}`` is replaced by the mission seed, and the
    names in ``places`` by where the program finds its peers. If it ``restarts``, each flight starts
    it anew, and otherwise the first. An invalid command is a ``UsageError``.
    """

    def __init__(self, option: str, command: str, places: Places, *, restarts: bool) -> None:
        self.restarts = restarts
        self.name = _NAMES[option]
        self._option = option
        try:
            self._words = shlex.split(command)
        except ValueError as error:
            raise UsageError(f"{option}: found {command!r}: {error}; expected a command") from error
        if not self._words:
            raise UsageError(f"{option}: found nothing; expected a command")
        self._places = places
        self.pid = 0
        self._keeper, self._connection = child_of(__name__)

    def start(self, seed: int) -> None:
        """End the program if it runs, and start it for a mission seed."""
        words = self._words
        for name, value in {**self._places, "{seed}": str(seed)}.items():
            words = [word.replace(name, value) for word in words]
        self._request(words)

    def stop(self) -> None:
        """End the program if it runs."""
        self._request([])

    def ended(self) -> TransportClosed | None:
        """Return how the program ended and what it wrote last, once; nothing while it runs."""
        with suppress(EOFError, OSError):
            if self._connection.poll():
                _, ending = self._connection.recv()
                self.pid = 0
                return TransportClosed(f"{self.name} ended: {ending}")
        return None

    @property
    def is_due(self) -> bool:
        """Whether the next flight has to start it."""
        return self.restarts or self.ended() is not None or not self.pid

    def close(self) -> None:
        """End the program, and wait for that."""
        self._connection.close()
        ending(self._keeper, 4.0)

    def _request(self, words: list[str]) -> None:
        """Have the keeper start a command, or only end the program if the command is empty."""
        try:
            self._connection.send(words)
            kind, answer = "ended", ""
            while kind == "ended":  # about the previous program
                kind, answer = self._connection.recv()
        except (EOFError, OSError) as error:
            what = f"the process that supervises {self.name} has ended"
            raise TransportClosed(what) from error
        if kind == "failed":
            raise TransportError(f"{self.name} did not start: {answer}; check {self._option}")
        self.pid = int(answer or 0)


if __name__ == "__main__":
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    Keeper(Connection(int(sys.argv[1]))).serve()
