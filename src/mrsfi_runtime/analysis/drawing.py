"""Figures drawn by a process of their own, which gets ready while this one searches.

matplotlib takes as long to import, and to draw three figures, as a whole search of compiled
evaluations.
"""

import gc
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


def draw_here(drawings: Drawings) -> Callable[[], None]:
    """Let figures be drawn by this process."""

    def finish() -> None:
        for drawing, stem in drawings:
            _save(drawn(drawing), stem)

    return finish


def _save(files: FigureFiles, stem: Path) -> None:
    for suffix, content in files.items():
        stem.with_suffix(suffix).write_bytes(content)


def drawn(drawing: Drawing, suffixes: Sequence[str] = (".png", ".svg")) -> FigureFiles:
    """Draw a figure in this process, for files of some suffixes."""
    from mrsfi_runtime.analysis.plots import rendered  # noqa: PLC0415 - matplotlib takes its time

    module = import_module(f"{__package__}.{drawing.module}")
    return rendered(getattr(module, drawing.function)(*drawing.arguments), suffixes)


class DrawingProcess:
    """A process that draws, first what is ``ahead``; it ends with the ``with`` block."""

    def __init__(self, *ahead: Drawing) -> None:
        self._ahead = ahead
        self._process: subprocess.Popen[bytes] | None = None
        self._thread = ThreadPoolExecutor(1)

    def __enter__(self) -> Self:
        with suppress(OSError):
            self._process = subprocess.Popen(
                [sys.executable, "-m", __name__],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                start_new_session=True,  # Ctrl-C reaches this process only, which ends that one
            )
        self._ready = [(drawing, self._begin(drawing)) for drawing in self._ahead]
        return self

    def __exit__(self, error: type[BaseException] | None, *_: object) -> None:
        self._thread.shutdown(wait=False, cancel_futures=True)
        if self._process is not None:
            if error is not None:
                self._process.kill()
            self._thread.shutdown()
            with suppress(BrokenPipeError), self._process:  # closes its pipes and waits for it
                pass

    def draw(self, drawings: Drawings) -> Callable[[], None]:
        """Begin to draw; what is returned saves all figures, and waits for those that are missing.

        It raises the ``OSError`` that saving met, and draws here what the process has not drawn.
        """
        begun = [(drawing, self._found(drawing), stem) for drawing, stem in drawings]

        def finish() -> None:
            for drawing, files, stem in begun:
                _save(files.result() or drawn(drawing), stem)

        return finish

    def _found(self, drawing: Drawing) -> Future[FigureFiles | None]:
        ready = (files for known, files in self._ready if known == drawing)
        return next(ready, None) or self._begin(drawing)

    def _begin(self, drawing: Drawing) -> Future[FigureFiles | None]:
        # Pickled here: what a mission has looked up grows in this thread meanwhile.
        return self._thread.submit(self._drawn_there, pickle.dumps(drawing))

    def _drawn_there(self, drawing: bytes) -> FigureFiles | None:
        """Return a figure that the process has drawn; ``None`` if there is none, or it failed."""
        process = self._process
        with suppress(OSError, EOFError, pickle.UnpicklingError):
            if process and process.stdin and process.stdout:
                process.stdin.write(drawing)
                process.stdin.flush()
                files: FigureFiles = pickle.load(process.stdout)
                return files
        return None


def main() -> None:
    """Draw what standard input says, as long as it says anything, and answer with each figure."""
    if hasattr(os, "nice"):
        os.nice(10)  # what is searched meanwhile comes first
    gc.disable()  # it takes a tenth of the time, for the 2 MB that some figures leave
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
