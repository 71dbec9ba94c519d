"""Makes the kernel and the regions of a mission known to numba, and compiles its flight."""

from functools import lru_cache, partial
from pathlib import Path
from types import FunctionType, ModuleType
from typing import Any

import numba
from numba.extending import register_jitable

from mrsfi_runtime.engine.compiled.batch_flight import Arrays
from mrsfi_runtime.engine.compiled.compilation_errors import CompilationError, explain
from mrsfi_runtime.engine.compiled.driver import (
    compiled_modules,
    load_driver,
    only_compiler,
    stub_of,
)
from mrsfi_runtime.engine.compiled.inlining import Inlined, bind
from mrsfi_runtime.engine.compiled.reach import kernel_functions
from mrsfi_runtime.errors import EvaluationError, WorkerLost
from mrsfi_runtime.fence import TimeLimitReached, apart, fenced, words
from mrsfi_runtime.kernel.flight import MissionFunctions
from mrsfi_runtime.mission import MissionCode

_typeof: Any = numba.typeof
_REGISTERED: set[FunctionType] = set()


class CompiledFlight:
    """The flight of a mission, compiled for the shapes of its arguments or found in the cache.

    Parameters
    ----------
    code
        Generated code of the mission.
    state_type
        Layout of its states.
    """

    def __init__(self, code: MissionCode, state_type: Any) -> None:
        self._code = code
        self._state_type = state_type
        _require_one_file(code)
        self._driver = _driver(code.functions, state_type)
        self._fly_many = self._driver.fly_many
        self._compiled: set[Any] = set()

    @property
    def folder(self) -> Path:
        """Where the compiled code is cached."""
        return Path(str(self._driver.__file__)).parent

    def __call__(self, arrays: Arrays, first: int, last: int) -> None:
        """Fly the specifications ``first … last - 1``.

        Raises
        ------
        CompilationError
            If a region cannot be compiled.
        """
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
            apart(partial(self._fly_many, arrays, first, last))

    def _compile(self, arrays: Arrays) -> None:
        """Compile before the call, so that an error of the compiler is none of the flight."""
        shapes = tuple(array.dtype for array in arrays)
        if shapes in self._compiled:
            return
        try:
            with only_compiler(self._driver):
                self._fly_many.compile((_typeof(arrays), _typeof(0), _typeof(0)))
                for compiled in self._fly_many.overloads.values():
                    bind(compiled)
        except Exception as error:
            raise explain(self._code, self._state_type, error) from error
        self._compiled.add(shapes)


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


@lru_cache(maxsize=16)
def _driver(functions: MissionFunctions, state_type: Any) -> ModuleType:
    """Return the driver of a mission's functions, the same for all of its engines."""
    for module in compiled_modules(functions):
        register(module)
    return load_driver(stub_of(functions, state_type))


def register(module: ModuleType) -> None:
    """Let compiled code call what it reaches from a module; the functions stay as they are."""
    for function in kernel_functions(module):
        if function not in _REGISTERED:
            _REGISTERED.add(function)
            register_jitable(
                boundscheck=True, forceinline=True, no_cfunc_wrapper=True, pipeline_class=Inlined
            )(function)
