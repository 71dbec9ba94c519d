"""The fence around what a team wrote: regions, what they import, and functions of a search.

Whatever such code raises becomes an error of its own, also what ends a process as a rule; what it
prints goes to standard error; the working folder is put back after it; and when it gets no further
for long, it is stopped. Time decides no result: what is stopped is recorded nowhere.
"""

import os
import sys
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from ctypes import c_ulong, py_object, pythonapi
from dataclasses import dataclass
from threading import RLock, Thread, get_ident
from time import sleep
from traceback import walk_stack
from types import FrameType, TracebackType

from mrsfi_runtime.errors import LIMITED, EvaluationError, MrsfiError, UsageError

_LOOK = 0.25  # seconds between two looks at how far code is
_N_TRIES = 8  # looks until what cannot be stopped takes the process with it
_end_process = os._exit


class TimeLimitReached(BaseException):
    """Raised in the midst of code that gets no further; no error that it may expect."""

    def __str__(self) -> str:
        return f"got no further for {_limit():g} s; if it needs longer, set MRSFI_TIME_LIMIT"


def _limit() -> float:
    """Return for how many seconds code may get no further; 0 for any time."""
    given = os.environ.get("MRSFI_TIME_LIMIT", "300")
    try:
        return float(given)
    except ValueError:
        raise UsageError(f"MRSFI_TIME_LIMIT: found '{given}'; expected seconds, or 0") from None


@contextmanager
def fenced(
    told: Callable[[BaseException], MrsfiError],
    progress: Callable[[], object] = lambda: None,
    patience: float = 0.0,
) -> Iterator[None]:
    """Run a team's code; Ctrl-C and errors of ours pass, all others are told.

    As long as its progress changes, no time is too long; nor are the seconds of patience.
    """
    limit = _limit()
    n_most = max(limit, patience) / _LOOK if limit else float("inf")
    try:
        with ExitStack() as left, _GUARD.watching(_Watch(told, progress, n_most)):
            with suppress(OSError):  # a folder that cannot be read
                here = os.open(".", os.O_RDONLY | os.O_CLOEXEC)
                left.callback(os.close, here)
                left.callback(os.fchdir, here)
            yield
    except (MrsfiError, KeyboardInterrupt):
        raise
    except BaseException as error:
        raise told(error) from error


def in_thread(call: Callable[[], object]) -> None:
    """Call machine code, which nothing can stop, in a thread that ends with this process."""
    raised: list[BaseException] = []

    def run() -> None:
        try:
            call()
        except BaseException as error:  # noqa: BLE001 - raised below
            raised.append(error)

    thread = Thread(target=run, daemon=True)
    thread.start()
    while thread.is_alive():
        thread.join(_LOOK)  # not for ever, or who waits could not be stopped either
    for error in raised:
        raise error


def words(error: BaseException) -> str:
    """Return what an error says, which a team may have written too."""
    try:
        return str(error)
    except BaseException:  # noqa: BLE001 - it may raise anything
        return "(which cannot be told)"


@dataclass(slots=True)
class _Watch:
    """How far code is, in looks and not in seconds: a process that was held has not stood still."""

    told: Callable[[BaseException], MrsfiError]
    progress: Callable[[], object]
    n_most: float
    seen: object = None
    n_looks: int = 0

    def look(self, thread: int, frame: FrameType) -> None:
        """Stop code that is overdue; end the process if that is to no avail."""
        stack = [each for each, _ in walk_stack(frame)]
        now = self.progress()
        if now != self.seen or any(each.f_trace for each in stack):  # or in a debugger
            self.n_looks, self.seen = 0, now
        self.n_looks += 1
        if self.n_looks > self.n_most + _N_TRIES:
            where = None
            for each in stack:
                where = TracebackType(where, each, each.f_lasti, each.f_lineno)
            error = self.told(TimeLimitReached().with_traceback(where))
            os.write(2, f"mrsfi: {error}\n".encode(errors="backslashreplace"))
            _end_process(EvaluationError.exit_code)
        if self.n_looks > self.n_most:
            pythonapi.PyThreadState_SetAsyncExc(c_ulong(thread), py_object(TimeLimitReached))


class _Guard:
    """Who is within the fence, by thread; meanwhile standard output is standard error."""

    def __init__(self) -> None:
        self._lock = RLock()
        self._watched: dict[int, _Watch] = {}
        self._watcher: Thread | None = None
        self._output = -1
        os.register_at_fork(after_in_child=self._watched.clear)

    @contextmanager
    def watching(self, watch: _Watch) -> Iterator[None]:
        thread = get_ident()
        with self._lock:
            outer = self._watched.get(thread)
            if not self._watched:
                self._begin()
            self._watched[thread] = watch
        try:
            yield
        finally:
            with self._lock:
                self._watched.pop(thread, None)
                if outer is not None:
                    self._watched[thread] = outer
                elif not self._watched:
                    self._end()

    def _begin(self) -> None:
        if self._watcher is None or not self._watcher.is_alive():
            self._watcher = Thread(target=self._look, daemon=True)
            try:
                self._watcher.start()
            except RuntimeError as error:
                raise UsageError(f"{error}: {LIMITED}") from error
        os._exit = self._exit  # type: ignore[assignment]  # the real one ends a command in silence
        with suppress(OSError, AttributeError, ValueError):  # a stream is closed
            sys.stdout.flush()
            self._output = os.dup(1)
            os.dup2(2, 1)

    def _end(self) -> None:
        os._exit = _end_process
        with suppress(OSError, AttributeError, ValueError):
            sys.stdout.flush()
        if self._output >= 0:
            os.dup2(self._output, 1)
            os.close(self._output)
            self._output = -1

    def _exit(self, status: int) -> None:
        if get_ident() in self._watched:
            raise SystemExit(status)
        _end_process(status)

    def _look(self) -> None:
        while True:
            sleep(_LOOK)
            with self._lock:
                frames = sys._current_frames()  # noqa: SLF001 - there is no other way
                for thread, watch in self._watched.items():
                    watch.look(thread, frames[thread])


_GUARD = _Guard()
