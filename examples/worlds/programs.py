"""Programs that a world starts: they end with it, whatever ends it.

``end`` ends a program. A world that is killed cannot call it: then Linux kills the program. On
other systems a program has to notice it by itself: its standard input ends, if that is a pipe.
"""

import ctypes
import os
import signal
import subprocess
import sys
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

from robots import WorldError

_PR_SET_PDEATHSIG = 1


def start(words: Sequence[str | Path], **options: Any) -> subprocess.Popen[str]:
    """Start a program; ``options`` are those of ``subprocess.Popen``.

    Linux kills it when the thread that started it ends, at the latest with the world. A program
    that is not there raises ``WorldError``.
    """
    text = [str(word) for word in words]
    try:
        return subprocess.Popen(text, preexec_fn=_mortal(), encoding="utf-8", **options)  # noqa: PLW1509 - nothing else binds it
    except OSError as error:
        raise WorldError(
            f"{error.filename or text[0]} cannot be started: {error.strerror}"
        ) from error


def _mortal() -> Callable[[], None] | None:
    """Return what has the system kill a program with this process, if the system is Linux."""
    if sys.platform != "linux":
        return None
    system, parent = ctypes.CDLL(None), os.getpid()

    def bind() -> None:
        system.prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)
        if os.getppid() != parent:  # killed in between
            os._exit(1)

    return bind


def end(*programs: subprocess.Popen[str]) -> None:
    """End programs, within two seconds each."""
    for program in programs:
        program.terminate()
    for program in programs:
        try:
            program.wait(2.0)
        except subprocess.TimeoutExpired:
            program.kill()
            program.wait()
        for pipe in filter(None, (program.stdin, program.stdout)):
            with suppress(BrokenPipeError):
                pipe.close()
