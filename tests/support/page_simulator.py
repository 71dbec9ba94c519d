"""The minimal simulator of docs/bus.md, run as the page prints it."""

import re
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from tests.support.tree import ROOT

PAGE = ROOT / "docs" / "bus.md"


def write_page_simulator(folder: Path, url: str, found: str = "", replaced: str = "") -> Path:
    """Write the simulator for a server, with a text in it replaced, and return its file."""
    example = re.search(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)
    assert example is not None
    assert found in example[1]
    text = example[1].replace(found, replaced) if found else example[1]
    path = folder / "minimal.py"
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
