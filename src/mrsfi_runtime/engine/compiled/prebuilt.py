"""The kernel as a wheel brings it: a library that was compiled before, and needs no compiler."""

import ctypes
import json
import os
import platform
import subprocess
import sys
from dataclasses import dataclass
from functools import cache
from hashlib import sha256
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from mrsfi_runtime.engine.compiled.machine_code import sources_key

FOLDER = Path(__file__).with_name("prebuilt")
PROCESSOR = "x86-64-v3"
_FEATURES = {"abm", "avx2", "bmi1", "bmi2", "f16c", "fma", "movbe"}
"""What the library runs on, and what Linux calls the features that such a processor has."""

_LIBRARY, _MANIFEST = "kernel.so", "kernel.json"


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


@cache
def prebuilt_kernel() -> Library | None:
    """Return the library, if there is one of these very sources that this machine can run."""
    try:
        told = json.loads((FOLDER / _MANIFEST).read_text(encoding="utf-8"))
        is_ours = told["sources"] == sources_key()
        is_whole = told["sha256"] == sha256((FOLDER / _LIBRARY).read_bytes()).hexdigest()
        is_known = (sys.platform, platform.machine()) == ("linux", "x86_64")
        features = Path("/proc/cpuinfo").read_text(encoding="utf-8").split() if is_known else ()
        if is_ours and is_whole and _FEATURES.issubset(features):
            return Library(FOLDER / _LIBRARY, tuple(told["names"]))
    except (OSError, ValueError, KeyError):
        pass
    return None


def build(folder: Path) -> None:
    """Compile the kernel into a library in a folder, and write what it is of beside it."""
    os.environ.update(NUMBA_CPU_NAME=PROCESSOR, NUMBA_CPU_FEATURES="")  # read as numba is imported
    import llvmlite.binding as llvm  # noqa: PLC0415 - in this order

    from mrsfi_runtime.engine.compiled.compiler import compiled_kernel  # noqa: PLC0415 - likewise

    target: Any = llvm.Target.from_triple("x86_64-unknown-linux-gnu")
    kernel = compiled_kernel(target.create_target_machine(cpu=PROCESSOR, reloc="pic"))
    folder.mkdir(parents=True, exist_ok=True)
    library = folder / _LIBRARY
    with TemporaryDirectory() as name:
        code = Path(name, "kernel.o")
        code.write_bytes(kernel.binary)
        flags = ("-shared", "--strip-all", "--no-undefined", "-z", "noexecstack")
        subprocess.run(["ld", *flags, "-o", library, code], check=True)
    told = {
        "sources": sources_key(),
        "sha256": sha256(library.read_bytes()).hexdigest(),
        "names": kernel.names,
        "processor": PROCESSOR,
    }
    (folder / _MANIFEST).write_text(json.dumps(told, indent=2) + "\n", encoding="utf-8")
