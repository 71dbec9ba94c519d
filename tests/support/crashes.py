"""What ends in the middle of writing: at any step of the file system, by a crash or a kill.

Python itself reports the steps (audit events), so that no way of writing goes round this.
"""

import json
import os
import shutil
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from itertools import count
from pathlib import Path
from typing import Any, NoReturn

from tests.support.tree import ROOT

_STEPS = ("os.rename", "os.remove", "os.mkdir", "os.rmdir", "os.truncate", "os.chmod")
_WRITES = os.O_WRONLY | os.O_RDWR | os.O_CREAT


class Crash(BaseException):
    """The process dies here; whatever it would still do to files fails as well."""


class _Steps:
    left = 0
    then: Callable[[], None] | None = None

    def count(self, event: str, values: tuple[Any, ...]) -> None:
        if self.then is None or not (event in _STEPS or (event == "open" and _writes(*values))):
            return
        self.left -= 1
        if self.left < 0:
            self.then()


def _writes(path: Any, mode: str | None, flags: int) -> bool:
    return bool(flags & _WRITES) and "__pycache__" not in str(path)


_COUNTED = _Steps()
sys.addaudithook(_COUNTED.count)


@contextmanager
def crash_after(n_steps: int, *, is_lasting: bool = True) -> Iterator[None]:
    """Let a body do so many steps on files and crash at the next; end quietly in either case.

    An interrupt does not last: what comes after it may do steps again.
    """

    def crash() -> NoReturn:
        if not is_lasting:
            _COUNTED.then = None
        raise Crash

    _COUNTED.left, _COUNTED.then = n_steps, crash
    try:
        with suppress(Crash):
            yield
    finally:
        _COUNTED.then = None


def killed(
    place: Path, work: Path, words: Sequence[str], then: Sequence[str], every: int = 1
) -> list[dict[str, Any]]:
    """Run ``mrsfi`` in copies of a folder, killed at each step; and another command after that.

    Parameters
    ----------
    place, work
        The folder, and where its copies go: ``0``, ``1``, …, by how many steps were done; ``done``
        is the one in which nothing was killed.
    words, then
        What follows ``mrsfi``, of the command that is killed and of the one after.
    every
        Only each so manieth step is one at which it is killed.

    Returns
    -------
    list
        For each copy its folder, the exit code of the second command, and what it told.
    """
    command = [
        sys.executable,
        "-m",
        __name__,
        json.dumps([str(place), str(work), words, then, every]),
    ]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    return [json.loads(line) for line in done.stdout.splitlines()]


def _main(place: str, work: str, words: list[str], then: list[str], every: int) -> None:
    from mrsfi_runtime.cli.main import main

    def run(copy: Path, command: list[str], left: int | None) -> int:
        child = os.fork()
        if child:
            return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
        os.chdir(copy)
        told = os.open(f"{copy}.told", os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
        os.dup2(told, 1)
        os.dup2(told, 2)
        if left is not None:
            _COUNTED.left = left
            _COUNTED.then = lambda: os.kill(os.getpid(), signal.SIGKILL)
        code = main(command)
        sys.stdout.flush()
        os._exit(code)

    def copied(name: str) -> Path:
        return Path(shutil.copytree(place, Path(work) / name))

    here = copied("done")
    os.chdir(here)
    sys.stdout, printed = sys.stderr, sys.stdout
    assert main(words) == 0  # imports all that the others need
    sys.stdout = printed
    for step in count(0, every):
        copy = copied(str(step))
        is_killed = run(copy, words, step) == -signal.SIGKILL
        if not is_killed:
            shutil.rmtree(copy)
            break
        code = run(copy, then, None)
        told = Path(f"{copy}.told").read_text(encoding="utf-8")
        sys.stdout.write(json.dumps({"folder": str(copy), "code": code, "told": told}) + "\n")


if __name__ == "__main__":
    _main(*json.loads(sys.argv[1]))
