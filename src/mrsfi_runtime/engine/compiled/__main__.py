"""Compiles the kernel into the cache; into a folder, if one is named, for a wheel to bring."""

import logging
import sys
from pathlib import Path

from mrsfi_runtime.engine.compiled.compiled_flight import kernel
from mrsfi_runtime.engine.compiled.machine_code import build

if __name__ == "__main__":
    logging.basicConfig(format="%(message)s")
    for name in sys.argv[1:]:
        build(Path(name))
    if not sys.argv[1:]:
        kernel()
