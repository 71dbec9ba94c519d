"""Which source this process runs: mrsfi's own, and what belongs to libraries."""

import os
from functools import cache
from hashlib import sha256
from pathlib import Path

import mrsfi_runtime

_ELSEWHERE = frozenset({"analysis", "causes", "cli", "search", "study"})
"""Rooms of mrsfi whose source no evaluation depends on."""

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
