"""Writes the stub from which numba compiles the flights of one mission, and loads it.

The stub only says whose functions fly. It goes to a file because numba caches only what it finds
in one. Numba does not notice when a function that the file calls has changed, so the file's
folder is named after all that compiled code may hold, by value, and after the shapes that it is
compiled for.
"""

import sys
from hashlib import sha256
from pathlib import Path
from types import ModuleType
from typing import Any, NamedTuple

import numpy as np

from mrsfi_runtime.engine.compiled import batch_flight
from mrsfi_runtime.engine.compiled.cache import cache_folder, is_sound
from mrsfi_runtime.engine.compiled.layout import recorded_words, state_type
from mrsfi_runtime.engine.compiled.reach import Reached
from mrsfi_runtime.kernel.flight import MissionFunctions
from mrsfi_runtime.kernel.initial import initial_state
from mrsfi_runtime.mission import MissionCode, load_module

_TEXT = '''"""Compiled flight of a mission."""

import {collective} as ci
import {effects} as own
from mrsfi_runtime.engine.compiled import batch_flight
from mrsfi_runtime.engine.compiled.own_guard import guarded
from mrsfi_runtime.kernel.flight import MissionFunctions
from numba import njit

apply = guarded(own.apply, {n_recorded}, {spans})


@njit(cache=True, nogil=True, boundscheck=True)
def fly_many(arrays, first, last):
    functions = MissionFunctions(ci.progress, ci.check, ci.react, apply)
    batch_flight.fly_many(functions, arrays, first, last)
'''


class Stub(NamedTuple):
    """Text of the stub of a mission, and a hash of all that decides what is compiled."""

    text: str
    key: str

    @property
    def name(self) -> str:
        """Name of its module."""
        return f"mrsfi_compiled_{self.key}"


def reached_by(functions: MissionFunctions) -> Reached:
    """Return what the compiled flight of a mission reaches, as the stub finds its functions."""
    collective, effects = _modules(functions)
    own = [vars(collective)[name] for name in MissionFunctions._fields[:-1]]
    return Reached([batch_flight.fly_many, *own, vars(effects)["apply"]])


def stub_of(functions: MissionFunctions, layout: Any, reached: Reached) -> Stub:
    """Return the stub of a mission, by its functions and the layout of its states."""
    collective, effects = _modules(functions)
    spans = [
        (layout.fields[name][1], layout.fields[name][0].itemsize) for name in ("mission", "map")
    ]
    text = _TEXT.format(
        collective=collective.__name__,
        effects=effects.__name__,
        n_recorded=recorded_words(layout),
        spans=tuple((first // 8, (first + size) // 8) for first, size in spans),
    )
    ours = [path.read_text(encoding="utf-8") for path in sorted(Path(__file__).parent.glob("*.py"))]
    parts = (sys.version, np.__version__, text, repr(layout), reached.text, *ours)
    return Stub(text, sha256("\0".join(parts).encode()).hexdigest()[:24])


def is_compiled(code: MissionCode, seed: int) -> bool:
    """Return whether a mission is compiled already, for some size of plans.

    Who only asks does not wait for numba to load.
    """
    layout = state_type(initial_state(code.mission, seed))
    return is_sound(
        cache_folder() / stub_of(code.functions, layout, reached_by(code.functions)).key
    )


def _modules(functions: MissionFunctions) -> tuple[ModuleType, ModuleType]:
    """Return the modules of a mission from which it is compiled."""
    return sys.modules[functions.check.__module__], sys.modules[functions.apply.__module__]


def load_driver(stub: Stub, path: Path) -> ModuleType:
    """Load a stub from a file, written before if need be."""
    if not path.is_file():
        path.write_text(stub.text, encoding="utf-8")
    return load_module(stub.name, path)
