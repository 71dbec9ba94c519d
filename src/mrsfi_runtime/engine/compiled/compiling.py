"""Makes the kernel and the regions of a mission known to numba, and compiles its flight."""

import sys
from functools import partial
from pathlib import Path
from types import FunctionType, ModuleType
from typing import Any

import numba

from mrsfi_runtime.engine.compiled.batch_flight import Arrays
from mrsfi_runtime.engine.compiled.cache import cache_folder, empty, sealing, temporary
from mrsfi_runtime.engine.compiled.compilation_errors import explain
from mrsfi_runtime.engine.compiled.driver import load_driver, reached_by, stub_of
from mrsfi_runtime.engine.compiled.inlining import bind, jitable
from mrsfi_runtime.engine.compiled.reach import CompilationError, Reached
from mrsfi_runtime.errors import EvaluationError, WorkerLost
from mrsfi_runtime.fence import TimeLimitReached, apart, fenced, words
from mrsfi_runtime.mission import MissionCode

_typeof: Any = numba.typeof
_REGISTERED: dict[FunctionType, str] = {}


class CompiledFlight:
    """The flight of a mission, compiled for the shapes of its arguments or found in the cache."""

    def __init__(self, code: MissionCode, state_type: Any) -> None:
        self._code = code
        self._state_type = state_type
        _require_one_file(code)
        reached = reached_by(code.functions)
        register(reached)
        self._stub = stub_of(code.functions, state_type, reached)
        self.key = self._stub.key
        self._driver: ModuleType | None = sys.modules.get(self._stub.name)
        self._compiled: set[Any] = set()

    @property
    def is_new(self) -> bool:
        """Whether this process has compiled it, and not found all of it in the cache."""
        return self._driver is not None and bool(self._driver.fly_many.stats.cache_misses)

    def __call__(self, arrays: Arrays, first: int, last: int) -> None:
        """Fly the specifications ``first … last - 1``, compiled if need be."""
        self._compile(arrays)

        def progress() -> tuple[int, int]:
            return int(arrays.at[0]), int(arrays.states[0]["mission"]["tick"])

        def told(error: BaseException) -> EvaluationError:
            if not isinstance(error, TimeLimitReached):
                return EvaluationError(words(error))
            return WorkerLost(
                f"{self._code.directory}: compiled, the mission stays at "
                f"tick {progress()[1]}: {error}; --engine reference tells the line"
            )

        with fenced(told, progress):
            apart(partial(self._driver.fly_many, arrays, first, last))  # type: ignore[union-attr]

    def forget(self) -> None:
        """Compile anew when it is called next."""
        sys.modules.pop(self._stub.name, None)
        with sealing(self._entry()):
            empty(self._entry())
        self._driver = None
        self._compiled.clear()

    def _entry(self) -> Path:
        """Return where the compiled code is cached."""
        if self._driver is not None:
            return Path(str(self._driver.__file__)).parent
        return cache_folder() / self.key

    def _compile(self, arrays: Arrays) -> None:
        """Compile before the call, so that an error of the compiler is none of the flight."""
        shapes = tuple(array.dtype for array in arrays)
        if shapes in self._compiled:
            return
        try:
            self._compile_in(self._entry(), arrays)
        except OSError as error:  # a full disk, say
            sys.modules.pop(self._stub.name, None)
            self._driver = None
            self._compile_in(temporary(self._entry().parent, str(error)) / self.key, arrays)
        self._compiled.add(shapes)

    def _compile_in(self, entry: Path, arrays: Arrays) -> None:
        with sealing(entry):
            if self._driver is None:
                self._driver = load_driver(self._stub, entry / "flight.py")
            fly_many = self._driver.fly_many
            try:
                fly_many.compile((_typeof(arrays), _typeof(0), _typeof(0)))
            except OSError:
                raise
            except Exception as error:
                raise explain(self._code, self._state_type, error) from error
            for compiled in fly_many.overloads.values():
                bind(compiled)


def _require_one_file(code: MissionCode) -> None:
    """Refuse functions that the flight could not call by name.

    Where the file was loaded again since, its module is another, of the same content.
    """
    for name, function in code.functions._asdict().items():
        names = function.__globals__ if name == "apply" else code.functions.check.__globals__
        if names.get(name) is not function:
            raise CompilationError(
                f"{code.directory}: '{name}' is no function of {names['__name__']}; "
                "expected the functions of one generated file"
            )


def register(reached: Reached) -> None:
    """Let compiled code call functions, unless they read other values than when first compiled."""
    for function in reached.functions:
        is_ours = function.__module__.startswith("mrsfi_runtime.")
        text = "" if is_ours else Reached([function], is_deep=False).text
        if function not in _REGISTERED:
            _REGISTERED[function] = text
            jitable(function)
        if _REGISTERED[function] != text:
            code = function.__code__
            raise CompilationError(
                f"{code.co_filename}:{code.co_firstlineno}: what '{function.__name__}' reads has "
                "changed since this process compiled it; begin another process"
            )
