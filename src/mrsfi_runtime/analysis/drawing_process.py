"""Figures drawn by a process of its own, which gets ready while this one searches.

matplotlib takes as long to import, and to draw, as a whole search of compiled evaluations.
"""

import os
import pickle
import subprocess
import sys
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from importlib import import_module
from pathlib import Path
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


def draw_here(drawings: Drawings) -> Callable[[], None]:
    """Let figures be drawn by this process."""
    return partial(_draw, drawings, [])


def _draw(drawings: Drawings, ready: Sequence[tuple[Drawing, FigureFiles]]) -> None:
    """Save figures, those that are ready as they are."""
    for drawing, stem in drawings:
        files = next((files for known, files in ready if known == drawing), None)
        for suffix, content in (files or _drawn(drawing)).items():
            stem.with_suffix(suffix).write_bytes(content)


def _drawn(drawing: Drawing) -> FigureFiles:
    from mrsfi_runtime.analysis import plots  # noqa: PLC0415 - matplotlib takes its time

    module = import_module(f"{plots.__package__}.{drawing.module}")
    return plots.rendered(getattr(module, drawing.function)(*drawing.arguments))


class DrawingProcess:
    """A process that draws what it is asked to; it ends with the ``with`` block, or with this one.

    Parameters
    ----------
    ahead
        Figures that it draws before it is asked to.
    """

    def __init__(self, *ahead: Drawing) -> None:
        self._ahead = ahead

    def __enter__(self) -> Self:
        self._process = subprocess.Popen(
            [sys.executable, "-m", __name__],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            start_new_session=True,  # Ctrl-C reaches this process only, which ends that one
        )
        self._send(self._ahead)
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        where: TracebackType | None,
    ) -> None:
        with suppress(BrokenPipeError), self._process:  # closes its pipes and waits for it
            if error is not None:
                self._process.kill()

    def draw(self, drawings: Drawings) -> Callable[[], None]:
        """Begin to draw; what is returned waits until all figures are saved, in the order of calls.

        It raises the ``OSError`` that saving met, and draws here if the process is gone.
        """
        self._send(drawings)
        return partial(self._finish, drawings)

    def _send(self, request: object) -> None:
        assert self._process.stdin is not None
        with suppress(BrokenPipeError):  # then there will be no answer
            pickle.dump(request, self._process.stdin)
            self._process.stdin.flush()

    def _finish(self, drawings: Drawings) -> None:
        assert self._process.stdout is not None
        try:
            error = pickle.load(self._process.stdout)
        except EOFError:
            draw_here(drawings)()
            return
        if error is not None:
            raise error


def main() -> None:
    """Draw what standard input says, as long as it says anything, and tell when each is done."""
    if hasattr(os, "nice"):
        os.nice(10)  # what is searched meanwhile comes first
    requests = sys.stdin.buffer
    try:
        ready = [(drawing, _drawn(drawing)) for drawing in pickle.load(requests)]
        while True:
            drawings = pickle.load(requests)
            error = None
            try:
                _draw(drawings, ready)
            except OSError as found:
                error = found
            pickle.dump(error, sys.stdout.buffer)
            sys.stdout.buffer.flush()
    except EOFError:
        return


if __name__ == "__main__":
    main()
