"""The fence around what a team wrote: regions, what they import, and functions of a search.

Whatever such code raises becomes an error of its own, also what ends a process as a rule; what it
prints goes to standard error; and when it gets no further for long, it is stopped. Time decides no
result: what is stopped is recorded nowhere.
"""

import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from ctypes import c_ulong, py_object, pythonapi
from threading import RLock, Thread, get_ident
from time import sleep
from traceback import walk_stack
from types import FrameType, TracebackType

from mrsfi_runtime.errors import EvaluationError, MrsfiError, UsageError

TIME_LIMIT = "MRSFI_TIME_LIMIT"
"""Variable: the seconds for which code may get no further; 0 for any time."""

_SECONDS = "300"
_LOOK = 0.25  # seconds between two looks at how far code is
_N_TRIES = 8  # looks until what cannot be stopped takes the process with it
_end_process = os._exit

Told = Callable[[BaseException], MrsfiError]
"""Returns what to raise for what a team's code raised."""


class TimeLimitReached(BaseException):
    """Raised in the midst of code that gets no further; no error that it may expect."""

    def __str__(self) -> str:
        return f"got no further for {_limit():g} s; if it needs longer, set {TIME_LIMIT}"


def words(error: BaseException) -> str:
    """Return what an error says, which a team may have written too."""
    try:
        return str(error)
    except BaseException:  # noqa: BLE001 - it may raise anything
        return "(which cannot be told)"


@contextmanager
def fenced(
    told: Told, progress: Callable[[], object] = lambda: None, patience: float = 0.0
) -> Iterator[None]:
    """Run a team's code; Ctrl-C and errors of ours pass.

    Parameters
    ----------
    progress
        Returns how far it is; while that changes, no time is too long.
    patience
        Seconds for which it may get no further, if that is more than the usual limit.
    """
    try:
        with _GUARD.watching(_Watch(told, progress, patience)):
            yield
    except (MrsfiError, KeyboardInterrupt):
        raise
    except BaseException as error:
        raise told(error) from error


def apart(call: Callable[[], object]) -> None:
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


class _Watch:
    """How far code is, in looks and not in seconds: a process that was held has not stood still."""

    def __init__(self, told: Told, progress: Callable[[], object], patience: float) -> None:
        self.told = told
        self._progress = progress
        limit = _limit()
        self._n_most = max(limit, patience) / _LOOK if limit else float("inf")
        self._seen: object = None
        self._n_looks = 0

    def overdue(self) -> float:
        """Look, and return by how many looks it is over the limit."""
        now = self._progress()
        self._n_looks = self._n_looks + 1 if now == self._seen else 0
        self._seen = now
        return self._n_looks - self._n_most


class _Guard:
    """Who is within the fence, by thread; meanwhile standard output is standard error."""

    def __init__(self) -> None:
        self._lock = RLock()
        self._watched: dict[int, _Watch] = {}
        self._watcher: Thread | None = None
        self._output: int | None = None
        os.register_at_fork(after_in_child=self._watched.clear)

    @contextmanager
    def watching(self, watch: _Watch) -> Iterator[None]:
        thread = get_ident()
        with self._lock:
            before = self._watched.get(thread)
            if not self._watched:
                self._begin()
            self._watched[thread] = watch
        try:
            yield
        finally:
            with self._lock:
                self._watched.pop(thread, None)
                if before is not None:
                    self._watched[thread] = before
                if not self._watched:
                    self._end()

    def _begin(self) -> None:
        if self._watcher is None or not self._watcher.is_alive():
            self._watcher = Thread(target=self._look, daemon=True)
            self._watcher.start()
        os._exit = self._exit  # type: ignore[assignment]  # it would end the command in silence
        with suppress(OSError, AttributeError):  # one of the two is closed
            sys.stdout.flush()
            self._output = os.dup(1)
            os.dup2(2, 1)

    def _end(self) -> None:
        os._exit = _end_process
        with suppress(OSError, AttributeError):
            sys.stdout.flush()
        if self._output is not None:
            os.dup2(self._output, 1)
            os.close(self._output)
            self._output = None

    def _exit(self, status: int) -> None:
        if get_ident() in self._watched:
            raise SystemExit(status)
        _end_process(status)

    def _look(self) -> None:
        while True:
            sleep(_LOOK)
            with self._lock:
                frames = sys._current_frames()
                for thread, watch in self._watched.items():
                    _look_at(thread, watch, frames[thread])


def _look_at(thread: int, watch: _Watch, frame: FrameType) -> None:
    """Stop code that is overdue; end the process if that is to no avail."""
    stack = [each for each, _ in walk_stack(frame)]
    if any(each.f_trace for each in stack):  # in a debugger
        return
    overdue = watch.overdue()
    if overdue > _N_TRIES:
        where = None
        for each in stack:
            where = TracebackType(where, each, each.f_lasti, each.f_lineno)
        error = watch.told(TimeLimitReached().with_traceback(where))
        os.write(2, f"mrsfi: {error}\n".encode(errors="backslashreplace"))
        _end_process(EvaluationError.exit_code)
    if overdue > 0:
        pythonapi.PyThreadState_SetAsyncExc(c_ulong(thread), py_object(TimeLimitReached))


def _limit() -> float:
    given = os.environ.get(TIME_LIMIT, _SECONDS)
    try:
        return float(given)
    except ValueError:
        raise UsageError(f"{TIME_LIMIT}: found '{given}'; expected seconds, or 0") from None


_GUARD = _Guard()
