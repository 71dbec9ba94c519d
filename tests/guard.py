"""What a test of the quick rooms may not do: start, open, compile or draw anything.

Python itself reports processes, sockets, files and imports (audit events), so that nothing goes
round this; what numba compiles and matplotlib draws is caught where they do it.
"""

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NoReturn

import pytest

from tests.support.tree import ROOT
from tests.tiers import FILELESS, QUICK

_PROCESSES = ("subprocess.Popen", "os.fork", "os.forkpty", "os.posix_spawn", "os.exec", "os.system")
_DOES = {
    "multiprocessing": "starts a process",
    "numba": "compiles something",
    "matplotlib": "draws something",
}
_WRITES = os.O_WRONLY | os.O_RDWR | os.O_CREAT
_OWN = (ROOT / ".hypothesis", ROOT / ".pytest_cache")
"""Where hypothesis and pytest write in the middle of a test."""


class ForbiddenError(AssertionError):
    """A test did what its room does not allow."""


class _Guard:
    """Refuses what a room does not allow, while a test of it runs.

    Attributes
    ----------
    room
        Room of the test that runs; empty between tests and in rooms that may do anything.
    is_fileless
        Whether nothing may be written either.
    found
        What the test did, also where product code caught the refusal.
    """

    def __init__(self) -> None:
        self.room = ""
        self.is_fileless = False
        self.found: list[str] = []

    def refuse(self, what: str) -> NoReturn:
        message = f"a test of tests/{self.room} {what}: do without, or move it ({__name__})"
        self.found.append(message)
        raise ForbiddenError(message)

    def judge(self, event: str, values: tuple[Any, ...]) -> None:
        """Judge an event that Python reports."""
        if not self.room:
            return
        if event in _PROCESSES:
            self.refuse(f"starts a process ({event})")
        elif event == "socket.__new__":
            self.refuse("opens a socket")
        elif event == "import" and values[0] in ("numba", "matplotlib"):
            self.refuse(f"{_DOES[values[0]]}, for it imports {values[0]}")
        elif event == "sqlite3.connect" and self.is_fileless and values[0] != ":memory:":
            self.refuse(f"opens database {values[0]}")
        elif event == "open" and self.is_fileless and _is_written(*values):
            self.refuse(f"writes file {values[0]}")


def _is_written(path: Any, mode: str | None, flags: int) -> bool:
    is_writing = any(letter in "wax+" for letter in mode) if mode else flags & _WRITES
    if isinstance(path, int) or not is_writing:
        return False
    file = Path(os.fsdecode(path))
    return "__pycache__" not in file.parts and not any(map(file.is_relative_to, _OWN))


_GUARD = _Guard()
sys.addaudithook(_GUARD.judge)


@contextmanager
def guard(room: str, *, is_writing_allowed: bool = False) -> Iterator[None]:
    """Hold a test to what its room may do.

    Parameters
    ----------
    room
        Folder below ``tests``; one that is not in ``QUICK`` may do anything.
    is_writing_allowed
        Whether files may be written in every room: pytest does so for its fixtures.
    """
    if room not in QUICK:
        yield
        return
    _GUARD.room, _GUARD.found = room, []
    _GUARD.is_fileless = room in FILELESS and not is_writing_allowed
    try:
        with pytest.MonkeyPatch.context() as patches:
            _bar(patches, "multiprocessing.process", "BaseProcess", "start")
            _bar(patches, "numba.core.dispatcher", "Dispatcher", "compile")
            _bar(patches, "matplotlib.figure", "Figure", "__init__")
            yield
    finally:
        _GUARD.room = ""
    if _GUARD.found:
        pytest.fail(_GUARD.found[0], pytrace=False)


def _bar(patches: pytest.MonkeyPatch, module: str, owner: str, method: str) -> None:
    """Refuse a method of a library, if it was imported."""
    if module in sys.modules:
        does = _DOES[module.partition(".")[0]]
        patches.setattr(
            getattr(sys.modules[module], owner), method, lambda *_, **__: _GUARD.refuse(does)
        )
