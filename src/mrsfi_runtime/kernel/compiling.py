"""The mark of functions that are written once and run interpreted or compiled.

A marked function, and all that it calls, keeps to the common subset: loops, comparisons,
``+ - * / // %``, ``min max abs round``, ``math.sqrt``, integer work, records with
attributes, other marked functions. No ``**`` on floats, no ``math.hypot``, no ``random``,
no container built on the way: those differ between the interpreter and a compiler, or do
not compile at all.
"""

from collections.abc import Callable
from typing import Any, TypeVar

Function = TypeVar("Function", bound=Callable[..., Any])


def kernel(function: Function) -> Function:
    """Mark a function as part of the world's kernel and return it unchanged."""
    function.__kernel__ = True  # type: ignore[attr-defined]
    return function
