"""Makes the kernel and the regions of a mission known to numba, and compiles its flight."""

import sys
from collections.abc import Sequence
from types import FunctionType, ModuleType
from typing import Any

import numba
from numba.extending import register_jitable

from mrsfi_runtime.engine.compiled.driver import driver_text, load_driver, source_hash
from mrsfi_runtime.engine.compiled.reach import constants, kernel_functions, sources
from mrsfi_runtime.engine.compiled.regions import CompilationError, explain
from mrsfi_runtime.kernel import delivery, effects, motion, tick
from mrsfi_runtime.kernel.goal_tasks import progress
from mrsfi_runtime.mission import MissionCode

_KERNEL = (delivery, effects, motion, progress, tick)
"""Modules that the flight calls; what they call is reached from them."""

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
        collective = sys.modules[code.checks[0].__module__]
        for module in (*_KERNEL, collective):
            _register(module)
        text = driver_text(code, collective.__name__)
        read = [path.read_text(encoding="utf-8") for path in sources(collective)]
        parts = [text, repr(state_type), *read, *constants(collective)]
        module = load_driver(source_hash(parts), text)
        self._fly_many = module.fly_many
        self._compiled: set[Any] = set()

    def __call__(self, *arguments: Any) -> None:
        """Fly; see the driver for the arguments.

        Raises
        ------
        CompilationError
            If a region cannot be compiled.
        """
        self._compile(arguments)
        self._fly_many(*arguments)

    def _compile(self, arguments: Sequence[Any]) -> None:
        """Compile before the call, so that an error of the compiler is none of the flight."""
        shapes = tuple(getattr(argument, "dtype", None) for argument in arguments)
        if shapes in self._compiled:
            return
        try:
            self._fly_many.compile(tuple(_typeof(argument) for argument in arguments))
        except Exception as error:
            raise explain(self._code, self._state_type, error) from error
        self._compiled.add(shapes)


def _require_one_file(code: MissionCode) -> None:
    """Refuse goal functions that the flight could not call by name.

    Where the file was loaded again since, its module is another, of the same content.
    """
    names = code.checks[0].__globals__
    for function in (*code.checks, *code.reactions):
        if names.get(function.__name__) is not function:
            message = (
                f"{code.directory}: '{function.__name__}' is no function of {names['__name__']}; "
                "expected the goal functions of one generated file"
            )
            raise CompilationError(message)


def _register(module: ModuleType) -> None:
    """Let compiled code call what it reaches from a module; the functions stay as they are."""
    for function in kernel_functions(module):
        if function not in _REGISTERED:
            _REGISTERED.add(function)
            register_jitable(boundscheck=True, forceinline=True, no_cfunc_wrapper=True)(function)
