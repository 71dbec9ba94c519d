"""Writes the stub from which numba compiles the flights of one mission, and loads it.

The stub only says whose functions fly. It goes to a file because numba caches only what it finds
in one. Numba does not notice when a function that the file calls has changed, so the file's
folder is named after a hash of all sources that take part, and of the shapes that they are
compiled for.
"""

import fcntl
import hashlib
import os
import shutil
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
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


def driver_text(collective: str, effects: str) -> str:
    """Return the stub of a mission.

    Parameters
    ----------
    collective
        Name under which its collective intelligence can be imported.
    effects
        The same of its fault effects.
    """
    return _TEXT.format(collective=collective, effects=effects)


def cache_folder() -> Path:
    """Return where compiled code is kept: ``MRSFI_CACHE``, else the user's cache folder."""
    own = os.environ.get("MRSFI_CACHE")
    if own:
        return Path(own)
    base = os.environ.get("XDG_CACHE_HOME")
    return (Path(base) if base else Path.home() / ".cache") / "mrsfi"


def source_hash(texts: Sequence[str]) -> str:
    """Return a key of some texts, for this version of Python."""
    sha = hashlib.sha256(sys.version.encode())
    for text in texts:
        sha.update(b"\0")
        sha.update(text.encode())
    return sha.hexdigest()[:24]


def _make_room(cache: Path) -> None:
    """Remove the oldest compiled missions but for one less than are kept; who uses one has it."""
    known = sorted(cache.glob("*/flight.py"), key=lambda path: path.stat().st_mtime, reverse=True)
    for path in known[N_KEPT - 1 :]:
        shutil.rmtree(path.parent, ignore_errors=True)


def load_driver(key: str, text: str) -> ModuleType:
    """Return the driver of a key, written to the cache folder before if need be."""
    name = f"mrsfi_compiled_{key}"
    if name in sys.modules:  # with what it has compiled
        return sys.modules[name]
    folder = cache_folder() / key
    path = folder / "flight.py"
    if not path.is_file():
        _make_room(folder.parent)
        folder.mkdir(parents=True, exist_ok=True)
        staged = folder / f"flight.{os.getpid()}.tmp"
        staged.write_text(text, encoding="utf-8")
        staged.replace(path)
    return load_module(name, path)


@contextmanager
def only_compiler(driver: ModuleType) -> Iterator[None]:
    """Let one process at a time compile a driver: whoever waits finds it in the cache."""
    with Path(str(driver.__file__)).with_name("lock").open("w") as file:
        with suppress(OSError):  # a file system without locks: then each compiles for itself
            fcntl.flock(file, fcntl.LOCK_EX)
        yield
