"""A team's node in a process of its own, started and ended as flights need it."""

import shlex
import sys
from contextlib import suppress
from multiprocessing import Pipe
from subprocess import DEVNULL, Popen, TimeoutExpired

from mrsfi_runtime.engine import node_keeper
from mrsfi_runtime.errors import TransportClosed, TransportError, UsageError

_ENDING_S = 4.0


class NodeProcess:
    """A node that dies with this process; ``pid`` is that of the last one that was started.

    ``command`` is a line in which ``{url}``, ``{host}``, ``{port}`` and ``{seed}`` are filled in:
    where it finds the server, and the mission seed. One that makes no sense is a ``UsageError``.
    """

    def __init__(self, command: str, url: str) -> None:
        try:
            self._words = shlex.split(command)
        except ValueError as error:
            raise UsageError(f"--node: found {command!r}: {error}; expected a command") from error
        if not self._words:
            raise UsageError("--node: found nothing; expected a command")
        self._url = url
        self.pid = 0
        self._connection, other_end = Pipe()
        with other_end:
            self._keeper = Popen(
                [sys.executable, "-m", node_keeper.__name__, str(other_end.fileno())],
                pass_fds=[other_end.fileno()],
                stdin=DEVNULL,
                start_new_session=True,  # Ctrl-C reaches this process only, which ends that one
            )

    def start(self, seed: int) -> None:
        """End the node if it runs, and start it for a mission seed."""
        address = self._url.partition("://")[2].partition("/")[0]
        host, _, port = address.rpartition(":")
        filled = {"{url}": self._url, "{host}": host, "{port}": port, "{seed}": str(seed)}
        words = []
        for word in self._words:
            for name, value in filled.items():
                word = word.replace(name, value)  # noqa: PLW2901 - one after the other
            words.append(word)
        self._say(words)

    def stop(self) -> None:
        """End the node if it runs."""
        self._say([])

    def ended(self) -> str:
        """Return how the node ended and what it wrote last, or nothing while it runs."""
        with suppress(EOFError, OSError):
            if self._connection.poll():
                _, said = self._connection.recv()
                self.pid = 0
                return str(said)
        return ""

    def close(self) -> None:
        """End the node, and wait for that."""
        self._connection.close()
        try:
            self._keeper.wait(_ENDING_S)
        except TimeoutExpired:
            self._keeper.kill()
            self._keeper.wait()

    def _say(self, words: list[str]) -> None:
        """Have the keeper start what words name, or end what it keeps if there are none."""
        try:
            self._connection.send(words)
            kind, said = "ended", ""
            while kind == "ended":  # of the one before
                kind, said = self._connection.recv()
        except (EOFError, OSError) as error:
            raise TransportClosed("the process that keeps the node has ended") from error
        if kind == "failed":
            raise TransportError(f"the node did not start: {said}; look at --node")
        self.pid = int(said or 0)
