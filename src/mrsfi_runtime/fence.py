"""The fence around user code: regions, their imports, and functions of a search.

Every exception of user code becomes an error of mrsfi, also one that usually ends a process. Its
output goes to standard error. The working folder is restored. Code without progress for long is
stopped. Time decides no result: a stopped evaluation is not recorded.

A campaign has copies of the modules that user code imports, under their names. Import statements in
code beside the copies, also during a flight, find modules of these names among the copies only. The
rest of the process keeps its own, so that campaigns with different modules of the same name can fly
in one process.

Begin with ``fenced`` for errors and time, with ``importing`` for the copies.
"""

import builtins
import os
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager, suppress
from ctypes import c_ulong, py_object, pythonapi
from dataclasses import dataclass
from functools import lru_cache
from importlib.machinery import ModuleSpec, PathFinder, SourceFileLoader
from pathlib import Path
from threading import RLock, Thread, get_ident
from time import sleep
from traceback import walk_stack
from types import FrameType, ModuleType, TracebackType
from typing import Any

from mrsfi_runtime.errors import LIMITED, EvaluationError, MrsfiError, UsageError

IMPORTED = "imported"  # subfolder of generated code that holds the copies
_MODULES = (".py", ".so")
_IMPORT = builtins.__import__


def copied_files(directory: Path) -> list[Path]:
    """Return the copies beside a folder's generated code, in order."""
    found = sorted((directory / IMPORTED).rglob("*"))
    return [path for path in found if path.is_file() and path.parent.name != "__pycache__"]


def team_file(spec: ModuleSpec | None) -> Path | None:
    """Return the file of a user's module; ``None`` for libraries and mrsfi."""
    if spec is None or not spec.has_location:
        return None
    path = Path(str(spec.origin))
    is_library = {"site-packages", "dist-packages"}.intersection(path.parts)
    others = {"mrsfi", "mrsfi_runtime", "mrsfi_bridge", "m2t", *sys.stdlib_module_names}
    is_other = path.suffix not in _MODULES or spec.name.partition(".")[0] in others
    return None if is_library or is_other else path


@contextmanager
def importing(directory: Path, module: ModuleType | None = None) -> Iterator[None]:
    """Let the body, and a module from now on, import the copies of a folder, if it has any."""
    folder = directory.absolute() / IMPORTED
    if not folder.is_dir():
        yield
        return
    files = copied_files(directory)
    copies = _copies(folder, tuple((path.name, path.read_bytes()) for path in files))
    if module is not None:
        vars(module)["__builtins__"] = copies.builtins
    with copies.found():
        yield


@lru_cache(maxsize=32)
def _copies(folder: Path, _: tuple[tuple[str, bytes], ...]) -> "_Copies":
    """Return the copies in a folder; as long as their content is the same, the same object."""
    return _Copies(folder)


class _Copies:
    """Modules that are imported from copies under the names of the originals."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        entries = (path for path in folder.iterdir() if path.is_dir() or path.suffix in _MODULES)
        self._tops = {path.name.partition(".")[0] for path in entries}
        self._modules: dict[str, ModuleType] = {}
        self._lock = RLock()
        self.builtins = {**vars(builtins), "__import__": self._import}

    @contextmanager
    def found(self) -> Iterator[None]:
        with self._lock:
            if self in sys.meta_path:
                yield
                return
            others = self._taken()
            sys.modules.update(self._modules)
            sys.meta_path.insert(0, self)
            try:
                yield
            finally:
                sys.meta_path.remove(self)
                self._modules = self._taken()
                sys.modules.update(others)

    def _taken(self) -> dict[str, ModuleType]:
        """Remove all modules of these names from the imported ones, and return them."""
        names = [name for name in sys.modules if name.partition(".")[0] in self._tops]
        return {name: sys.modules.pop(name) for name in names}

    def _import(
        self, name: str, scope: Any = None, local: Any = None, parts: Any = (), level: int = 0
    ) -> ModuleType:
        """Import as a statement does; quickly, because a statement in a flight runs often."""
        top = (str(scope["__package__"]) if level else name).partition(".")[0]
        if top not in self._tops:
            return _IMPORT(name, scope, local, parts, level)
        module = None if level else self._modules.get(name)
        if module is not None and all(hasattr(module, part) for part in parts or ()):
            return module if parts else self._modules[top]
        with self.found():
            return _IMPORT(name, scope, local, parts, level)

    def find_spec(
        self, name: str, path: Sequence[str] | None, _: ModuleType | None = None
    ) -> ModuleSpec | None:
        """Return the place of a copy; refuse a user's module without a copy."""
        if name.partition(".")[0] not in self._tops:
            file = team_file(PathFinder.find_spec(name, path))
            if file is not None:
                raise ImportError(
                    f"found {file}, of which the campaign has no copy, because no import statement "
                    f"names '{name}'; write `import {name}` where it is needed"
                )
            return None
        place = self._folder.joinpath(*name.split("."))
        spec = PathFinder.find_spec(name, [str(place.parent)])
        if spec is not None and spec.submodule_search_locations is not None:
            spec.submodule_search_locations = [*spec.submodule_search_locations]  # only these
        if spec is not None and isinstance(spec.loader, SourceFileLoader):
            spec.loader = loader = _Loader(name, str(spec.origin))
            loader.scope = self.builtins
        return spec


class _Loader(SourceFileLoader):
    """Gives a module the import statement of the copies before it runs."""

    scope: Mapping[str, Any]

    def exec_module(self, module: ModuleType) -> None:
        vars(module)["__builtins__"] = self.scope
        super().exec_module(module)


_LOOK = 0.25  # seconds between two checks of progress
_N_TRIES = 8  # checks until the process of code that cannot be stopped is ended
_end_process = os._exit


class TimeLimitReached(BaseException):
    """Raised in code without progress; user code does not catch it as an ``Exception``."""

    def __str__(self) -> str:
        return f"made no progress for {_limit():g} s; if it needs longer, set MRSFI_TIME_LIMIT"


def _limit() -> float:
    """Return for how many seconds code may be without progress; 0 for no limit."""
    given = os.environ.get("MRSFI_TIME_LIMIT", "300")
    try:
        return float(given)
    except ValueError:
        raise UsageError(f"MRSFI_TIME_LIMIT: found '{given}'; expected seconds, or 0") from None


@contextmanager
def fenced(
    as_ours: Callable[[BaseException], MrsfiError],
    progress: Callable[[], object] = lambda: None,
    patience: float = 0.0,
) -> Iterator[None]:
    """Run user code; Ctrl-C and errors of mrsfi pass, ``as_ours`` translates all others.

    Time is unlimited as long as ``progress`` changes, and for at least ``patience`` seconds.
    """
    limit = _limit()
    n_most = max(limit, patience) / _LOOK if limit else float("inf")
    try:
        with ExitStack() as left, _GUARD.watching(_Watch(as_ours, progress, n_most)):
            with suppress(OSError):  # a folder that cannot be read
                here = os.open(".", os.O_RDONLY | os.O_CLOEXEC)
                left.callback(os.close, here)
                left.callback(os.fchdir, here)
            yield
    except (MrsfiError, KeyboardInterrupt):
        raise
    except BaseException as error:
        raise as_ours(error) from error


def in_thread(call: Callable[[], object]) -> None:
    """Call machine code, which cannot be stopped, in a thread that ends with this process."""
    raised: list[BaseException] = []

    def run() -> None:
        try:
            call()
        except BaseException as error:  # noqa: BLE001 - raised below
            raised.append(error)

    thread = Thread(target=run, daemon=True)
    thread.start()
    while thread.is_alive():
        thread.join(_LOOK)  # with a limit, so that this thread can be stopped
    for error in raised:
        raise error


def words(error: BaseException) -> str:
    """Return the text of an error, whose ``__str__`` may be user code."""
    try:
        return str(error)
    except BaseException:  # noqa: BLE001 - it may raise anything
        return "(its text cannot be read)"


@dataclass(slots=True)
class _Watch:
    """Progress of code, in checks and not in seconds, so that suspended code is not stopped."""

    as_ours: Callable[[BaseException], MrsfiError]
    progress: Callable[[], object]
    n_most: float
    last: object = None
    n_checks: int = 0

    def check(self, thread: int, frame: FrameType) -> None:
        """Stop code that is overdue; if it goes on, end the process."""
        stack = [each for each, _ in walk_stack(frame)]
        now = self.progress()
        if now != self.last or any(each.f_trace for each in stack):  # or in a debugger
            self.n_checks, self.last = 0, now
        self.n_checks += 1
        if self.n_checks > self.n_most + _N_TRIES:
            where = None
            for each in stack:
                where = TracebackType(where, each, each.f_lasti, each.f_lineno)
            error = self.as_ours(TimeLimitReached().with_traceback(where))
            os.write(2, f"mrsfi: {error}\n".encode(errors="backslashreplace"))
            _end_process(EvaluationError.exit_code)
        if self.n_checks > self.n_most:
            pythonapi.PyThreadState_SetAsyncExc(c_ulong(thread), py_object(TimeLimitReached))


class _Guard:
    """The watched code by thread; meanwhile standard output goes to standard error."""

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
                    watch.check(thread, frames[thread])


_GUARD = _Guard()
