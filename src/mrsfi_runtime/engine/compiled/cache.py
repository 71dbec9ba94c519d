"""Where compiled code is kept: in a folder that is this user's alone, each entry sealed.

Whoever loads what numba keeps runs what it holds. So nothing is read from a folder that others may
write to, nor from an entry that is not, byte for byte, what was sealed under its key.
"""

import atexit
import fcntl
import logging
import os
import shutil
from collections.abc import Callable
from contextlib import suppress
from hashlib import sha256
from pathlib import Path
from tempfile import mkdtemp

from mrsfi_runtime.engine.compiled.regions import CompilationError
from mrsfi_runtime.files import telling_of_temporary_files

FILE = "code"
N_KEPT = 512
"""Regions and kernels that the cache keeps; a region takes some 10 kB, a kernel 140."""


def cache_folder() -> Path:
    """Return ``MRSFI_CACHE``, else the user's cache folder, or tell the user of another one."""
    users = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    folder = Path(os.environ.get("MRSFI_CACHE") or Path(users, "mrsfi"))
    try:
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        why = _distrusted(folder)
    except OSError as error:
        why = "it is no folder" if folder.exists() else error.strerror or str(error)
    return temporary(folder, why) if why else folder


def _distrusted(folder: Path) -> str:
    """Return why nothing is to be kept in a folder; empty if it is this user's alone."""
    about = folder.stat()
    if about.st_uid != os.getuid():
        return f"it belongs to user {about.st_uid}, expected {os.getuid()}"
    if about.st_mode & 0o022:
        return f"others may write to it (mode {about.st_mode & 0o777:o}, expected 700)"
    return "" if os.access(folder, os.W_OK | os.X_OK) else "it cannot be written to"


def temporary(folder: Path, why: str) -> Path:
    """Return a folder for this process and those that it starts, in the place of another."""
    try:
        own = mkdtemp(prefix="mrsfi_")
    except OSError as error:
        raise CompilationError(f"{folder}: cannot keep compiled code: {why}; {error}") from error
    atexit.register(shutil.rmtree, own, ignore_errors=True)
    os.environ["MRSFI_CACHE"] = own
    remedy = "it is lost when this command ends; make it yours (chmod 700) or set MRSFI_CACHE"
    told = "warning: %s: compiled code is not kept there: %s; %s"
    logging.getLogger(__name__).warning(told, folder, why, remedy)
    return Path(own)


def kept(key: str, make: Callable[[], bytes]) -> tuple[bytes, bool]:
    """Return what is kept under a key, made if need be, and whether it was."""
    folder = cache_folder()
    try:
        return _kept_in(folder / key, make)
    except OSError as error:  # a full disk, say
        with telling_of_temporary_files():
            return _kept_in(temporary(folder, str(error)) / key, make)


def forget(key: str) -> None:
    """Have it made anew when it is asked for next."""
    (cache_folder() / key / FILE).unlink(missing_ok=True)


def _kept_in(entry: Path, make: Callable[[], bytes]) -> tuple[bytes, bool]:
    """Return what an entry keeps; one process at a time makes it, and seals it in the end."""
    _make_room(entry)
    if entry.is_symlink() or entry.is_file():
        entry.unlink()
    entry.mkdir(mode=0o700, exist_ok=True)
    file = entry / FILE
    with (entry / "lock").open("w") as lock:
        with suppress(OSError):  # a file system without locks: then each compiles for itself
            fcntl.flock(lock, fcntl.LOCK_EX)
        seal, _, content = file.read_bytes().partition(b"\n") if file.is_file() else (b"", b"", b"")
        if seal == sealed(entry.name, content):
            file.touch()
            return content, False
        content = make()
        file.write_bytes(sealed(entry.name, content) + b"\n" + content)
        return content, True


def sealed(key: str, content: bytes) -> bytes:
    """Return the seal of what is kept under a key; under another key it has another one."""
    return sha256(key.encode() + b"\n" + content).hexdigest().encode()


def _make_room(new: Path) -> None:
    """Remove the oldest entries but for one less than are kept; who uses one has it."""
    if not new.exists():
        known = [(path.stat().st_mtime, path.parent) for path in new.parent.glob(f"*/{FILE}")]
        for _, entry in sorted(known, reverse=True)[N_KEPT - 1 :]:
            shutil.rmtree(entry, ignore_errors=True)
