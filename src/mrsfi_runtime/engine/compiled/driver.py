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
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from hashlib import sha256
from pathlib import Path
from types import ModuleType

from mrsfi_runtime.mission import load_module

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


def load_driver(collective: str, effects: str, parts: Sequence[str]) -> ModuleType:
    """Return the stub of a mission, written to the cache folder before if need be.

    Parameters
    ----------
    collective, effects
        Names under which its collective intelligence and its fault effects can be imported.
    parts
        All else that decides what is compiled, as texts.
    """
    text = _TEXT.format(collective=collective, effects=effects)
    key = sha256("\0".join((sys.version, text, *parts)).encode()).hexdigest()[:24]
    name = f"mrsfi_compiled_{key}"
    if name in sys.modules:  # with what it has compiled
        return sys.modules[name]
    path = _cache_folder() / key / "flight.py"
    if not path.is_file():
        _make_room(path.parent.parent)
        path.parent.mkdir(parents=True, exist_ok=True)
        staged = path.with_suffix(f".{os.getpid()}.tmp")
        staged.write_text(text, encoding="utf-8")
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
