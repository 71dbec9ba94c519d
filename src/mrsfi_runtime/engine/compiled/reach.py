"""What compiled code reaches from a module: kernel functions and constants, however deep."""

import inspect
from collections.abc import Iterator, Mapping
from enum import EnumMeta
from pathlib import Path
from types import CodeType, FunctionType, ModuleType
from typing import Any, TypeGuard

import numpy as np

_FROZEN = (bool, int, float, complex, str, bytes, tuple, np.ndarray, np.generic, EnumMeta)
"""What numba makes a constant of."""


def kernel_functions(module: ModuleType) -> list[FunctionType]:
    """Return the kernel functions of a module, and all that they call in whatever file."""
    found: dict[FunctionType, None] = {}
    waiting = [value for value in vars(module).values() if is_kernel(value)]
    while waiting:
        function = waiting.pop()
        if function not in found:
            found[function] = None
            waiting += [value for _, value in _named(function) if is_kernel(value)]
    return list(found)


def sources(module: ModuleType) -> list[Path]:
    """Return the file of a module, and those of all kernel functions that it reaches."""
    files = {inspect.getfile(function) for function in kernel_functions(module)}
    return sorted(Path(file) for file in {*files, str(module.__file__)})


def constants(module: ModuleType) -> list[str]:
    """Return what numba freezes into compiled code: numbers, texts, tuples, arrays from outside."""
    return sorted(
        {
            f"{function.__module__}.{name} {_written(value)}"
            for function in kernel_functions(module)
            for name, value in _named(function)
            if isinstance(value, _FROZEN)
        }
    )


def is_kernel(value: object) -> TypeGuard[FunctionType]:
    """Return whether a value is a function of the kernel, or marked as one."""
    return isinstance(value, FunctionType) and bool(getattr(value, "__kernel__", False))


def _named(function: FunctionType) -> Iterator[tuple[str, Any]]:
    """Yield what a function names, and what it may name of modules among it; and its defaults."""
    names = [*_names(function.__code__)]
    cells = zip(function.__code__.co_freevars, function.__closure__ or (), strict=True)
    around = {name: cell.cell_contents for name, cell in cells}
    scopes: list[tuple[str, Mapping[str, Any]]] = [("", {**function.__globals__, **around})]
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
    for place, value in enumerate(function.__defaults__ or ()):
        yield f"{function.__name__}, default {place}", value


def _names(code: CodeType) -> Iterator[str]:
    """Yield the names of a function that are not its own, those in its comprehensions too."""
    yield from (*code.co_names, *code.co_freevars)
    for inner in code.co_consts:
        if isinstance(inner, CodeType):
            yield from _names(inner)


def _written(value: Any) -> str:
    if isinstance(value, EnumMeta):
        return repr([*value])
    content = getattr(value, "tobytes", None)  # texts of long arrays leave numbers out
    return repr(value) if content is None else f"{value.dtype} {value.shape} {content().hex()}"
