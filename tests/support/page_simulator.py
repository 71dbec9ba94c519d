"""The minimal simulator of docs/bus.md, run as the page prints it."""

import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from tests.support.pages import blocks
from tests.support.tree import ROOT

PAGE = ROOT / "docs" / "bus.md"


def write_page_simulator(folder: Path, url: str, found: str = "", replaced: str = "") -> Path:
    """Write the simulator for a server, with a text in it replaced, and return its file."""
    (example,) = (block for block in blocks(PAGE.read_text(encoding="utf-8")) if block.file)
    text = "".join(f"{line}\n" for line in example.lines)
    assert found in text
    text = text.replace(found, replaced) if found else text
    path = folder / example.file
    path.write_text(text.replace("ws://127.0.0.1:9090", url), encoding="utf-8")
    return path


@contextmanager
def page_simulator(folder: Path, url: str, found: str = "", replaced: str = "") -> Iterator[None]:
    """Run the simulator beside the body."""
    program = write_page_simulator(folder, url, found, replaced)
    with subprocess.Popen([sys.executable, program]) as running:
        try:
            yield
        finally:
            running.kill()
