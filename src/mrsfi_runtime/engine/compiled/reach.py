"""What compiled code reaches from a module: kernel functions and constants, however deep."""

import inspect
from collections.abc import Iterator, Mapping
from pathlib import Path
from types import FunctionType, ModuleType
from typing import Any, TypeGuard

import numpy as np

_FROZEN = (bool, int, float, complex, str, bytes, tuple, np.ndarray, np.generic)
"""What numba makes a constant of."""


def kernel_functions(module: ModuleType) -> list[FunctionType]:
    """Return the kernel functions of a module, and all that they call in whatever file."""
    found: dict[FunctionType, None] = {}
    waiting = [value for value in vars(module).values() if is_kernel(value)]
    while waiting:
        function = waiting.pop()
        if function not in found:
            found[function] = None
            waiting += [value for _, value in _globals(function) if is_kernel(value)]
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
            if isinstance(value, _FROZEN)
        }
    )


def is_kernel(value: object) -> TypeGuard[FunctionType]:
    """Return whether a value is a function of the kernel, or marked as one."""
    return isinstance(value, FunctionType) and bool(getattr(value, "__kernel__", False))


def _globals(function: FunctionType) -> Iterator[tuple[str, Any]]:
    """Yield the globals that a function names, and what it may name of modules among them."""
    names = function.__code__.co_names
    scopes: list[tuple[str, Mapping[str, Any]]] = [("", function.__globals__)]
    seen = set()
    for prefix, scope in scopes:  # which grows
        for name in names:
            if name not in scope:
                continue
            value = scope[name]
            yield f"{prefix}{name}", value
            if isinstance(value, ModuleType) and value not in seen:
                seen.add(value)
                scopes.append((f"{prefix}{name}.", vars(value)))


def _written(value: Any) -> str:
    content = getattr(value, "tobytes", None)  # texts of long arrays leave numbers out
    return repr(value) if content is None else f"{value.dtype} {value.shape} {content().hex()}"
