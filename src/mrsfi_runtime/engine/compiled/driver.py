"""Writes the stub from which numba compiles the flights of one mission, and loads it.

The stub only says whose functions fly. It goes to a file because numba caches only what it finds
in one. Numba does not notice when a function that the file calls has changed, so the file's
folder is named after a hash of all sources that take part, and of the shapes that they are
compiled for.
"""

import fcntl
import os
import shutil
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from functools import lru_cache
from hashlib import sha256
from pathlib import Path
from types import ModuleType
from typing import Any, NamedTuple

from mrsfi_runtime.engine.compiled import batch_flight
from mrsfi_runtime.engine.compiled.layout import state_type
from mrsfi_runtime.engine.compiled.reach import constants, sources
from mrsfi_runtime.kernel.flight import MissionFunctions
from mrsfi_runtime.kernel.initial import initial_state
from mrsfi_runtime.mission import MissionCode, load_module

N_KEPT = 64
"""Compiled missions that the cache keeps; one takes about 2 MB."""

_TEXT = '''"""Compiled flight of a mission."""

import {collective} as ci
import {effects} as own
from mrsfi_runtime.engine.compiled import batch_flight
from mrsfi_runtime.kernel.flight import MissionFunctions
from numba import njit


@njit(cache=True, nogil=True, boundscheck=True)
def fly_many(arrays, first, last):
    functions = MissionFunctions(ci.progress, ci.check, ci.react, own.apply)
    batch_flight.fly_many(functions, arrays, first, last)
'''


class Stub(NamedTuple):
    """Text of the stub of a mission, and a hash of all that decides what is compiled."""

    text: str
    key: str

    @property
    def path(self) -> Path:
        """Its file; beside it numba keeps what it compiled."""
        return _cache_folder() / self.key / "flight.py"


@lru_cache(maxsize=16)
def stub_of(functions: MissionFunctions, layout: Any) -> Stub:
    """Return the stub of a mission, by its functions and the layout of its states."""
    modules = compiled_modules(functions)
    _, collective, effects = modules
    text = _TEXT.format(collective=collective.__name__, effects=effects.__name__)
    parts = [sys.version, text, repr(layout)]
    for module in modules:
        parts += [path.read_text(encoding="utf-8") for path in sources(module)]
        parts += constants(module)
    return Stub(text, sha256("\0".join(parts).encode()).hexdigest()[:24])


def is_compiled(code: MissionCode, seed: int) -> bool:
    """Return whether a mission is compiled already, for some size of plans.

    Who only asks does not wait for numba to load.
    """
    stub = stub_of(code.functions, state_type(initial_state(code.mission, seed)))
    return any(stub.path.parent.glob("__pycache__/*.nbc"))


def compiled_modules(functions: MissionFunctions) -> tuple[ModuleType, ...]:
    """Return the modules from which a mission is compiled; the last two are its own."""
    own = (functions.check.__module__, functions.apply.__module__)
    return (batch_flight, *(sys.modules[name] for name in own))


def load_driver(stub: Stub) -> ModuleType:
    """Load a stub, written to the cache folder before if need be."""
    name = f"mrsfi_compiled_{stub.key}"
    if name in sys.modules:  # with what it has compiled
        return sys.modules[name]
    path = stub.path
    if not path.is_file():
        _make_room(path.parent.parent)
        path.parent.mkdir(parents=True, exist_ok=True)
        staged = path.with_suffix(f".{os.getpid()}.tmp")
        staged.write_text(stub.text, encoding="utf-8")
        staged.replace(path)
    return load_module(name, path)


def _cache_folder() -> Path:
    """Return where compiled code is kept: ``MRSFI_CACHE``, else the user's cache folder."""
    users = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Path(os.environ.get("MRSFI_CACHE") or Path(users, "mrsfi"))


def _make_room(cache: Path) -> None:
    """Remove the oldest compiled missions but for one less than are kept; who uses one has it."""
    known = sorted(cache.glob("*/flight.py"), key=lambda path: path.stat().st_mtime, reverse=True)
    for path in known[N_KEPT - 1 :]:
        shutil.rmtree(path.parent, ignore_errors=True)


@contextmanager
def only_compiler(driver: ModuleType) -> Iterator[None]:
    """Let one process at a time compile a driver: whoever waits finds it in the cache."""
    with Path(str(driver.__file__)).with_name("lock").open("w") as file:
        with suppress(OSError):  # a file system without locks: then each compiles for itself
            fcntl.flock(file, fcntl.LOCK_EX)
        yield
