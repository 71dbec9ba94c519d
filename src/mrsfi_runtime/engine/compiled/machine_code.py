"""Machine code: kept in a cache, each function under a key, and loaded without numba.

A process that loads compiled code runs it. So mrsfi reads nothing from a folder to which other
users may write, and no entry whose bytes differ from those sealed under its key. The first half is
this cache; begin with ``kept``. The second half makes keys, loads object files, and finds the
kernel that a wheel contains as a library, which needs no compiler.
"""

import atexit
import ctypes
import fcntl
import json
import os
import pickle
import platform
import sys
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import cache
from hashlib import sha256
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import mrsfi_runtime
from mrsfi_runtime.engine.compiled.regions import CompilationError
from mrsfi_runtime.errors import UsageError
from mrsfi_runtime.files import temporary_files_writable
from mrsfi_runtime.project_file import installed_version

FILE = "code"
N_KEPT = 512
"""Number of regions and kernels in the cache; a region takes about 10 kB, a kernel 140 kB."""


def cache_folder() -> Path:
    """Return ``MRSFI_CACHE``, else the user's cache folder, or a temporary one with a warning."""
    folder, why = _lasting()
    return temporary(folder, why) if why else folder


def _lasting() -> tuple[Path, str]:
    """Return the folder for all commands, and why it cannot be used, if it cannot."""
    users = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    folder = Path(os.environ.get("MRSFI_CACHE") or Path(users, "mrsfi"))
    try:
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        return folder, _distrusted(folder)
    except OSError as error:
        return folder, "it is no folder" if folder.exists() else error.strerror or str(error)


def remembered(
    key: str, make: Callable[[], bytes], is_current: Callable[[bytes], bool] = bool
) -> bytes:
    """Return the content of a key if it is current; else make it, and keep it where possible."""
    folder, why = _lasting()
    if not why:
        with suppress(OSError):
            return _kept_in(folder / key, make, is_current)[0]
    return make()


def _distrusted(folder: Path) -> str:
    """Return why a folder cannot be used; empty if only this user can write to it."""
    about = folder.stat()
    if about.st_uid != os.getuid():
        return f"it belongs to user {about.st_uid}, expected {os.getuid()}"
    if about.st_mode & 0o022:
        return f"others may write to it (mode {about.st_mode & 0o777:o}, expected 700)"
    return "" if os.access(folder, os.W_OK | os.X_OK) else "it cannot be written to"


def temporary(folder: Path, why: str) -> Path:
    """Return a temporary folder for this process and its children, in place of another."""
    import logging  # noqa: PLC0415 - slow, like all here
    import shutil  # noqa: PLC0415
    from tempfile import mkdtemp  # noqa: PLC0415

    try:
        own = mkdtemp(prefix="mrsfi_")
    except OSError as error:
        raise CompilationError(f"{folder}: cannot store compiled code: {why}; {error}") from error
    atexit.register(shutil.rmtree, own, ignore_errors=True)
    os.environ["MRSFI_CACHE"] = own
    logging.getLogger(__name__).warning(
        "warning: %s: compiled code is not cached there: %s; it is lost when this command ends; "
        "make the folder yours (chmod 700) or set MRSFI_CACHE",
        *(folder, why),
    )
    return Path(own)


def kept(key: str, make: Callable[[], bytes]) -> tuple[bytes, bool]:
    """Return the content of a key, made if it is missing, and whether it was made now."""
    folder = cache_folder()
    try:
        return _kept_in(folder / key, make)
    except OSError as error:  # a full disk, say
        with temporary_files_writable():
            return _kept_in(temporary(folder, str(error)) / key, make)


def forget(key: str) -> None:
    """Remove an entry, so that the next request makes it again."""
    (cache_folder() / key / FILE).unlink(missing_ok=True)


def _kept_in(
    entry: Path, make: Callable[[], bytes], is_current: Callable[[bytes], bool] = bool
) -> tuple[bytes, bool]:
    """Return the content of an entry; one process at a time makes it, and then seals it."""
    _make_room(entry)
    if entry.is_symlink() or entry.is_file():
        entry.unlink()
    entry.mkdir(mode=0o700, exist_ok=True)
    file = entry / FILE
    with (entry / "lock").open("w") as lock:
        with suppress(OSError):  # a file system without locks: then each compiles for itself
            fcntl.flock(lock, fcntl.LOCK_EX)
        seal, _, content = file.read_bytes().partition(b"\n") if file.is_file() else (b"", b"", b"")
        if seal == sealed(entry.name, content) and is_current(content):
            file.touch()
            return content, False
        content = make()
        file.write_bytes(sealed(entry.name, content) + b"\n" + content)
        return content, True


def sealed(key: str, content: bytes) -> bytes:
    """Return the seal of a content under a key; it differs between keys."""
    return sha256(key.encode() + b"\n" + content).hexdigest().encode()


def _make_room(new: Path) -> None:
    """Remove the oldest entries to make room for one; processes have loaded those they use."""
    if not new.exists():
        import shutil  # noqa: PLC0415 - slow

        known = [(path.stat().st_mtime, path.parent) for path in new.parent.glob(f"*/{FILE}")]
        for _, entry in sorted(known, reverse=True)[N_KEPT - 1 :]:
            shutil.rmtree(entry, ignore_errors=True)


_SOURCES = ("kernel", "model", "engine/compiled", "engine/recording.py")
_LOADED: dict[bytes, tuple[Any, list[int]]] = {}

FOLDER = Path(__file__).with_name("prebuilt")
PROCESSOR = "x86-64-v3"
_FEATURES = {"abm", "avx2", "bmi1", "bmi2", "f16c", "fma", "movbe"}
"""The processor features that the library needs, as Linux names them."""

NEAR: dict[str, Any] = {"reloc": "pic", "codemodel": "small"}
"""Options of a machine whose code and constants lie within 2 GiB: addresses are offsets in code.

By default they are numbers of 64 bits, which fill registers: flights take longer. Such code is
loaded into one block. LLVM reserves no room in it for a table of addresses of external symbols, and
ends the process where one is needed, so this is for the kernel, which needs none.
"""

LIBRARY, MANIFEST = "kernel.so", "kernel.json"


@dataclass(frozen=True, slots=True)
class Library:
    """A shared library, and the names of functions in it."""

    path: Path
    names: tuple[str, ...]

    def addresses(self) -> list[int]:
        """Return where the functions lie, for as long as this process runs."""
        library = ctypes.CDLL(str(self.path))
        found = [ctypes.cast(getattr(library, name), ctypes.c_void_p) for name in self.names]
        return [address.value or 0 for address in found]


@dataclass(frozen=True, slots=True)
class MachineCode:
    """An object file, the names of functions in it, and of external symbols that it needs.

    ``is_near`` says whether it was made with ``NEAR``.
    """

    names: tuple[str, ...]
    binary: bytes
    taken: tuple[str, ...] = ()
    is_near: bool = False

    def addresses(self) -> list[int]:
        """Return where the functions lie, for as long as this process runs."""
        if self.binary not in _LOADED:
            for name in _missing(self.taken):  # sqrt, say; looked up here, importing numba is slow
                if found := getattr(ctypes.CDLL(None), name, None):
                    _llvm().add_symbol(name, ctypes.cast(found, ctypes.c_void_p).value)
            if _missing(self.taken):  # lists, say
                lend_runtime()
            if _missing(self.taken):
                raise CompilationError(f"compiled code lacks {' and '.join(_missing(self.taken))}")
            llvm = _llvm()
            in_one_block = {"use_lmm": True} if self.is_near else {}
            machine = this_machine(is_near=self.is_near)
            engine = llvm.create_mcjit_compiler(llvm.parse_assembly(""), machine, **in_one_block)
            engine.add_object_file(llvm.ObjectFileRef.from_data(self.binary))
            engine.finalize_object()
            found = [engine.get_function_address(name) for name in self.names]
            if not all(found):
                raise CompilationError(f"compiled code lacks one of {self.names}")
            _LOADED[self.binary] = engine, found
        return _LOADED[self.binary][1]


def lend_runtime() -> None:
    """Register the symbols of numba that compiled code needs."""
    from numba.core.registry import cpu_target  # noqa: PLC0415 - slow
    from numba.core.runtime.nrt import rtsys  # noqa: PLC0415 - slow

    rtsys.initialize(cpu_target.target_context)


def _missing(names: Sequence[str]) -> list[str]:
    return [name for name in names if not _llvm().address_of_symbol(name)]


def _llvm() -> Any:
    import llvmlite.binding  # noqa: PLC0415 - optional

    return llvmlite.binding


def _processor() -> tuple[str, str, str]:
    llvm = _llvm()
    features = llvm.get_host_cpu_features().flatten()
    return llvm.get_process_triple(), llvm.get_host_cpu_name(), features


@cache
def this_machine(*, is_near: bool) -> Any:
    """Return what makes code with ``NEAR``, and loads code, for this processor."""
    llvm, (triple, cpu, features) = _llvm(), _processor()
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    target = llvm.Target.from_triple(triple)
    options = NEAR if is_near else {}
    return target.create_target_machine(cpu=cpu, features=features, opt=3, jit=True, **options)


@cache
def sources_key() -> str:
    """Return a key of the sources of the kernel."""
    root = Path(str(mrsfi_runtime.__file__)).parent
    known = (path for name in _SOURCES for path in (root / name).rglob("*.py"))
    files = sorted({*known, *(root / name for name in _SOURCES if name.endswith(".py"))})
    return key_of(*(path.read_text(encoding="utf-8") for path in files))


@cache
def kernel_key() -> str:
    """Return a key of all that the compiled kernel depends on: its text, compiler, machine."""
    if find_spec("numba") is None:
        raise UsageError("compilation needs numba; install it with: pip install 'mrsfi[fast]'")
    parts = [sys.version, *map(installed_version, ("numba", "llvmlite", "numpy"))]
    return key_of(sources_key(), *parts, *_processor())


def key_of(*parts: str) -> str:
    """Return a key that no other texts have."""
    return sha256("\0".join(parts).encode()).hexdigest()[:24]


def kept_code(key: str, compile_: Callable[[], MachineCode]) -> tuple[MachineCode, bool]:
    """Return the code of a key, cached or compiled now, and whether it was compiled now."""
    content, is_new = kept(key, lambda: pickle.dumps(compile_()))
    return pickle.loads(content), is_new


@cache
def prebuilt_kernel() -> Library | None:
    """Return the library, if it was built from these sources and this machine can run it."""
    try:
        about = json.loads((FOLDER / MANIFEST).read_text(encoding="utf-8"))
        is_ours = about["seal"] == library_seal(about["names"], (FOLDER / LIBRARY).read_bytes())
        is_known = (sys.platform, platform.machine()) == ("linux", "x86_64")
        features = Path("/proc/cpuinfo").read_text(encoding="utf-8").split() if is_known else ()
        if is_ours and _FEATURES.issubset(features):
            return Library(FOLDER / LIBRARY, tuple(about["names"]))
    except (OSError, ValueError, KeyError):
        pass
    return None


def library_seal(names: Sequence[str], library: bytes) -> str:
    """Return the seal of a library of these sources, with functions in this order."""
    return sealed(key_of(sources_key(), *names), library).decode()


_POINTERS = (ctypes.POINTER(ctypes.c_int64), ctypes.POINTER(ctypes.c_void_p), ctypes.c_void_p)
FLIGHT = ctypes.CFUNCTYPE(ctypes.c_int32, *_POINTERS, ctypes.c_int64, ctypes.c_int64)
"""The arguments of compiled code: addresses for result and error; the frame, and its span."""
