"""The mark of functions that are written once and run interpreted or compiled.

A marked function, and all that it calls, keeps to the common subset: loops, comparisons,
``+ - * / // %``, ``min max abs round``, ``math.sqrt``, integer work, records with
attributes, other marked functions. No ``**`` on floats, no ``math.hypot``, no ``random``,
no container built on the way: those differ between the interpreter and a compiler, or do
not compile at all.
"""

from collections.abc import Callable
from types import FunctionType
from typing import Any, TypeGuard, TypeVar

Function = TypeVar("Function", bound=Callable[..., Any])


def kernel(function: Function) -> Function:
    """Mark a function as part of the world's kernel and return it unchanged."""
    function.__kernel__ = True  # type: ignore[attr-defined]
    return function


def is_kernel(value: object) -> TypeGuard[FunctionType]:
    """Return whether a value is a function of the kernel, or marked as one."""
    return isinstance(value, FunctionType) and bool(getattr(value, "__kernel__", False))
