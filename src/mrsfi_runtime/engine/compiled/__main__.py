"""Compiles the kernel into the cache; into a folder, if one is named, for a wheel to bring."""

import json
import logging
import os
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from mrsfi_runtime.engine.compiled.engine import kernel
from mrsfi_runtime.engine.compiled.machine_code import (
    LIBRARY,
    MANIFEST,
    NEAR,
    PROCESSOR,
    library_seal,
)


def build(folder: Path) -> None:
    """Compile the kernel into a library in a folder, with a manifest of its sources beside it."""
    os.environ.update(NUMBA_CPU_NAME=PROCESSOR, NUMBA_CPU_FEATURES="")  # read as numba is imported
    import llvmlite.binding as llvm  # noqa: PLC0415 - in this order

    from mrsfi_runtime.engine.compiled.compiler import compiled_kernel  # noqa: PLC0415 - likewise

    target: Any = llvm.Target.from_triple("x86_64-unknown-linux-gnu")
    compiled = compiled_kernel(target.create_target_machine(cpu=PROCESSOR, **NEAR))
    folder.mkdir(parents=True, exist_ok=True)
    library = folder / LIBRARY
    with TemporaryDirectory() as name:
        code = Path(name, "kernel.o")
        code.write_bytes(compiled.binary)
        flags = ("-shared", "--strip-all", "--no-undefined", "-z", "noexecstack")
        subprocess.run(["ld", *flags, "-o", library, code], check=True)
    seal = library_seal(compiled.names, library.read_bytes())
    manifest = {"seal": seal, "names": compiled.names, "processor": PROCESSOR}
    (folder / MANIFEST).write_text(json.dumps(manifest, indent=2) + "\n", encoding="utf-8")


if __name__ == "__main__":
    logging.basicConfig(format="%(message)s")
    for name in sys.argv[1:]:
        build(Path(name))
    if not sys.argv[1:]:
        kernel()
