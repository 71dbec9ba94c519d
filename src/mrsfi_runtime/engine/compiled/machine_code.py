"""Machine code: kept in the cache, each function under a key, and loaded without numba.

A wheel brings the kernel as a library that was compiled before, and needs no compiler.
"""

import ctypes
import json
import platform
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from hashlib import sha256
from importlib.metadata import version
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import mrsfi_runtime
from mrsfi_runtime.engine.compiled.cache import kept, sealed
from mrsfi_runtime.engine.compiled.regions import CompilationError
from mrsfi_runtime.errors import UsageError

_SOURCES = ("kernel", "model", "engine/compiled", "engine/recording.py")
_LOADED: dict[bytes, tuple[Any, list[int]]] = {}

FOLDER = Path(__file__).with_name("prebuilt")
PROCESSOR = "x86-64-v3"
_FEATURES = {"abm", "avx2", "bmi1", "bmi2", "f16c", "fma", "movbe"}
"""What the library runs on, and what Linux calls the features that such a processor has."""

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
    """An object file, the names of functions in it, and of what it takes from elsewhere."""

    names: tuple[str, ...]
    binary: bytes
    taken: tuple[str, ...] = ()

    def addresses(self) -> list[int]:
        """Return where the functions lie, for as long as this process runs."""
        if self.binary not in _LOADED:
            if _missing(self.taken):  # lists, say
                lend_runtime()
            if _missing(self.taken):
                raise CompilationError(f"compiled code lacks {' and '.join(_missing(self.taken))}")
            llvm = _llvm()
            engine = llvm.create_mcjit_compiler(llvm.parse_assembly(""), _machine())
            engine.add_object_file(llvm.ObjectFileRef.from_data(self.binary))
            engine.finalize_object()
            found = [engine.get_function_address(name) for name in self.names]
            if not all(found):
                raise CompilationError(f"compiled code lacks one of {self.names}")
            _LOADED[self.binary] = engine, found
        return _LOADED[self.binary][1]


def lend_runtime() -> None:
    """Make known what compiled code takes from numba."""
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
def _machine() -> Any:
    llvm = _llvm()
    triple, cpu, features = _processor()
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    target = llvm.Target.from_triple(triple)
    return target.create_target_machine(cpu=cpu, features=features, jit=True)


@cache
def sources_key() -> str:
    """Return a key of the text of all that the kernel is compiled from."""
    root = Path(str(mrsfi_runtime.__file__)).parent
    known = (path for name in _SOURCES for path in (root / name).rglob("*.py"))
    files = sorted({*known, *(root / name for name in _SOURCES if name.endswith(".py"))})
    return key_of(*(path.read_text(encoding="utf-8") for path in files))


@cache
def kernel_key() -> str:
    """Return a key of all that decides how the kernel compiles: its text, compiler, machine."""
    if find_spec("numba") is None:
        raise UsageError("to compile takes numba; install it with: pip install 'mrsfi[fast]'")
    parts = [sys.version, *(version(name) for name in ("numba", "llvmlite", "numpy"))]
    return key_of(sources_key(), *parts, *_processor())


def key_of(*parts: str) -> str:
    """Return a key that no other texts have."""
    return sha256("\0".join(parts).encode()).hexdigest()[:24]


def kept_code(key: str, compile_: Callable[[], MachineCode]) -> tuple[MachineCode, bool]:
    """Return what the cache keeps under a key, compiled if need be, and whether it was."""

    def make() -> bytes:
        code = compile_()
        return json.dumps([code.names, code.taken]).encode() + b"\n" + code.binary

    content, is_new = kept(key, make)
    head, _, binary = content.partition(b"\n")
    names, taken = map(tuple, json.loads(head))
    return MachineCode(names, binary, taken), is_new


@cache
def prebuilt_kernel() -> Library | None:
    """Return the library, if there is one of these very sources that this machine can run."""
    try:
        told = json.loads((FOLDER / MANIFEST).read_text(encoding="utf-8"))
        is_ours = told["seal"] == library_seal(told["names"], (FOLDER / LIBRARY).read_bytes())
        is_known = (sys.platform, platform.machine()) == ("linux", "x86_64")
        features = Path("/proc/cpuinfo").read_text(encoding="utf-8").split() if is_known else ()
        if is_ours and _FEATURES.issubset(features):
            return Library(FOLDER / LIBRARY, tuple(told["names"]))
    except (OSError, ValueError, KeyError):
        pass
    return None


def library_seal(names: Sequence[str], library: bytes) -> str:
    """Return the seal of a library: of these very sources, and of its functions in this order."""
    return sealed(key_of(sources_key(), *names), library).decode()


FLIGHT = ctypes.CFUNCTYPE(
    ctypes.c_int32,
    ctypes.POINTER(ctypes.c_int64),
    ctypes.POINTER(ctypes.c_void_p),
    ctypes.c_void_p,
    ctypes.c_int64,
    ctypes.c_int64,
)
"""How compiled code is called: where the result goes, and an error; then what flies."""
