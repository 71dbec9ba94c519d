"""Which source this process runs: mrsfi's own, a team's, and libraries."""

import os
import sys
from functools import cache
from hashlib import sha256
from pathlib import Path
from types import ModuleType

import mrsfi_runtime

_ELSEWHERE = frozenset({"analysis", "causes", "cli", "search", "study"})
"""Rooms of mrsfi whose source no evaluation depends on."""

_OURS = ("mrsfi_runtime", "mrsfi_bridge", "m2t")
_LOADED_BY_US = ("mrsfi_generated_", "mrsfi_compiled_")
_LIBRARIES = (f"{Path(os.__file__).parent}/", "/site-packages/", "/dist-packages/")


@cache
def source_hash() -> str:
    """Return a hash of all source of mrsfi on which evaluations depend."""
    package = Path(str(mrsfi_runtime.__file__)).parent
    digest = sha256()
    for path in sorted(package.rglob("*.py")):
        if path.relative_to(package).parts[0] not in _ELSEWHERE:
            digest.update(path.name.encode() + path.read_bytes())
    return digest.hexdigest()[:8]


def is_library(file: str) -> bool:
    """Return whether a file belongs to Python or to an installed library."""
    return any(library in file for library in _LIBRARIES)


def team_files() -> list[Path]:
    """Return the files of all modules that are loaded, but for libraries, ours, and generated."""
    files = set()
    for name, module in [*sys.modules.items()]:
        if name.partition(".")[0] in _OURS or name.startswith(_LOADED_BY_US):
            continue
        file = vars(module).get("__file__") if isinstance(module, ModuleType) else None
        if file is not None and not is_library(file):
            files.add(Path(file))
    return sorted(files)
