"""On PYTHONPATH, it lets a test's processes leave figures empty, where nobody looks at them."""

from pathlib import Path
from typing import Any

from mrsfi_runtime.analysis.summary import Illustration

drawn: Any = Illustration.save


def save(illustration: Illustration, folder: Path, *suffixes: str) -> None:
    if suffixes:  # for a paper
        drawn(illustration, folder, *suffixes)
        return
    for suffix in (".png", ".svg"):
        (folder / f"{illustration.name}{suffix}").write_bytes(b"")


replaced: Any = Illustration
replaced.save = save
