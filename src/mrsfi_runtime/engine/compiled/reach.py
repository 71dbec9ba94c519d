"""What compiled code reaches from a module: kernel functions and constants, however deep."""

import inspect
from collections.abc import Iterator
from pathlib import Path
from types import FunctionType, ModuleType
from typing import Any


def kernel_functions(module: ModuleType) -> list[FunctionType]:
    """Return the kernel functions of a module, and all that they call in whatever file."""
    found: dict[FunctionType, None] = {}
    waiting = [value for value in vars(module).values() if _is_kernel(value)]
    while waiting:
        function = waiting.pop()
        if function not in found:
            found[function] = None
            waiting += [value for _, value in _globals(function) if _is_kernel(value)]
    return list(found)


def sources(module: ModuleType) -> list[Path]:
    """Return the file of a module, and those of all kernel functions that it reaches."""
    files = {inspect.getfile(function) for function in kernel_functions(module)}
    return sorted(Path(file) for file in {*files, str(module.__file__)})


def constants(module: ModuleType) -> list[str]:
    """Return what numba freezes into compiled code: global numbers, texts, tuples, arrays."""
    return sorted(
        {
            f"{function.__module__}.{name} {_written(value)}"
            for function in kernel_functions(module)
            for name, value in _globals(function)
            if not callable(value) and not isinstance(value, ModuleType)
        }
    )


def _is_kernel(value: object) -> bool:
    return isinstance(value, FunctionType) and bool(getattr(value, "__kernel__", False))


def _globals(function: FunctionType) -> Iterator[tuple[str, Any]]:
    """Yield the globals that a function names, and those of modules that it names them of."""
    names = function.__code__.co_names
    for name in names:
        value = function.__globals__.get(name)
        yield name, value
        if isinstance(value, ModuleType):
            known = vars(value)
            yield from ((f"{name}.{part}", known[part]) for part in names if part in known)


def _written(value: Any) -> str:
    content = getattr(value, "tobytes", None)  # texts of long arrays leave numbers out
    return repr(value) if content is None else f"{value.dtype} {value.shape} {content().hex()}"
