"""Files of figures that nobody looks at, without content; drawing takes longer than most tests."""

from pathlib import Path
from typing import Any

from mrsfi_runtime.analysis.summary import Illustration

drawn: Any = Illustration.save


def save(illustration: Illustration, folder: Path, *suffixes: str) -> None:
    """Write empty files in place of a figure, unless it is for a paper."""
    if suffixes:
        drawn(illustration, folder, *suffixes)
        return
    for suffix in (".png", ".svg"):
        (folder / f"{illustration.name}{suffix}").write_bytes(b"")
