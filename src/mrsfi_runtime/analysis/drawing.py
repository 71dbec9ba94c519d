"""Figures drawn by processes of their own, the first of which gets ready while this one searches.

matplotlib takes as long to import, and to draw three figures, as a whole search of compiled
evaluations.
"""

import os
import pickle
import subprocess
import sys
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import suppress
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from queue import SimpleQueue
from types import TracebackType
from typing import Any, Self, TypeAlias


@dataclass(frozen=True, slots=True)
class Drawing:
    """A figure to come: the module of ``analysis`` and its function that draw it, and what from."""

    function: str
    arguments: tuple[Any, ...]
    module: str = "plots"


Drawings: TypeAlias = Sequence[tuple[Drawing, Path]]
"""Drawings with the path of each one's files, without suffix."""

FigureFiles: TypeAlias = Mapping[str, bytes]
"""What the files of a figure hold, by suffix."""

Draw: TypeAlias = Callable[[Drawings], Callable[[], None]]
"""Takes figures to be drawn and saved; what it returns waits until all are, or draws them."""

_MOST = 4  # processes, each of which takes some 100 MB
_WORTH = 4  # figures that wait for one, before another is worth its time to import matplotlib


def draw_here(drawings: Drawings) -> Callable[[], None]:
    """Let figures be drawn by this process."""

    def finish() -> None:
        for drawing, stem in drawings:
            _save(drawn(drawing), stem)

    return finish


def _save(files: FigureFiles, stem: Path) -> None:
    for suffix, content in files.items():
        stem.with_suffix(suffix).write_bytes(content)


def drawn(drawing: Drawing) -> FigureFiles:
    """Draw a figure in this process."""
    from mrsfi_runtime.analysis import plots  # noqa: PLC0415 - matplotlib takes its time

    module = import_module(f"{plots.__package__}.{drawing.module}")
    return plots.rendered(getattr(module, drawing.function)(*drawing.arguments))


class DrawingProcesses:
    """Processes that draw what they are asked to; they end with the ``with`` block, or this one.

    There are as many as processors, up to four, each begun when enough figures wait.

    Parameters
    ----------
    ahead
        Figures that one of them draws before they are asked for.
    """

    def __init__(self, *ahead: Drawing) -> None:
        self._ahead = ahead
        self._processes: list[subprocess.Popen[bytes]] = []
        self._idle: SimpleQueue[subprocess.Popen[bytes] | None] = SimpleQueue()  # None: one failed
        self._begun: list[Future[FigureFiles | None]] = []
        self._n_most = min(_MOST, os.cpu_count() or 1)
        self._threads = ThreadPoolExecutor(self._n_most)

    def __enter__(self) -> Self:
        self._ready = [(drawing, self._begin(drawing)) for drawing in self._ahead]
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        where: TracebackType | None,
    ) -> None:
        self._threads.shutdown(wait=False, cancel_futures=True)
        if error is not None:
            for process in self._processes:
                process.kill()
        self._threads.shutdown()
        for process in self._processes:
            with suppress(BrokenPipeError), process:  # closes its pipes and waits for it
                pass

    def draw(self, drawings: Drawings) -> Callable[[], None]:
        """Begin to draw; what is returned saves all figures, and waits for those that are missing.

        It raises the ``OSError`` that saving met, and draws here what no process has drawn.
        """
        begun = [(drawing, self._found(drawing), stem) for drawing, stem in drawings]

        def finish() -> None:
            for drawing, files, stem in begun:
                _save(files.result() or drawn(drawing), stem)

        return finish

    def _found(self, drawing: Drawing) -> Future[FigureFiles | None]:
        """Return what was drawn ahead, or begin to draw."""
        ready = (files for known, files in self._ready if known == drawing)
        return next(ready, None) or self._begin(drawing)

    def _begin(self, drawing: Drawing) -> Future[FigureFiles | None]:
        """Begin to draw, by one process more where that is worth it."""
        n_waiting = sum(not figure.done() for figure in self._begun)
        n_processes = len(self._processes)
        if n_processes < self._n_most and n_waiting >= _WORTH * n_processes:
            try:
                self._idle.put(self._started())
            except OSError:
                self._idle.put(None)
        self._begun.append(self._threads.submit(self._drawn_there, drawing))
        return self._begun[-1]

    def _drawn_there(self, drawing: Drawing) -> FigureFiles | None:
        """Return a figure that a process has drawn; ``None`` if one failed."""
        with suppress(OSError, EOFError, pickle.UnpicklingError):
            process = self._idle.get()
            if process is not None:
                assert process.stdin is not None
                assert process.stdout is not None
                pickle.dump(drawing, process.stdin)
                process.stdin.flush()
                files: FigureFiles = pickle.load(process.stdout)
                self._idle.put(process)
                return files
        self._idle.put(None)  # for whoever waits as well
        return None

    def _started(self) -> subprocess.Popen[bytes]:
        process = subprocess.Popen(
            [sys.executable, "-m", __name__],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            start_new_session=True,  # Ctrl-C reaches this process only, which ends that one
        )
        self._processes.append(process)
        return process


def main() -> None:
    """Draw what standard input says, as long as it says anything, and answer with each figure."""
    if hasattr(os, "nice"):
        os.nice(10)  # what is searched meanwhile comes first
    try:
        while True:
            files = drawn(pickle.load(sys.stdin.buffer))
            pickle.dump(files, sys.stdout.buffer)
            sys.stdout.buffer.flush()
    except EOFError:
        return
    except BrokenPipeError:  # nor is anybody to be told of it when Python ends
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


if __name__ == "__main__":
    main()
