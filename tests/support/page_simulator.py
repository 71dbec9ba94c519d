"""The minimal simulator of docs/bus.md, run as the page prints it."""

import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace
from typing import Any

from mrsfi_runtime.transport import topics
from tests.support.pages import blocks
from tests.support.tree import ROOT

PAGE = ROOT / "docs" / "bus.md"


@contextmanager
def page_simulator(folder: Path, url: str, found: str = "", replaced: str = "") -> Iterator[None]:
    """Run the simulator beside the body."""
    name, text = _program(found, replaced)
    program = folder / name
    program.write_text(text, encoding="utf-8")
    with subprocess.Popen([sys.executable, program, url]) as running:
        try:
            yield
        finally:
            running.kill()


def join_page_simulator(transport: topics.Transport, found: str = "", replaced: str = "") -> None:
    """Have the simulator join a transport of this process, which it takes for roslibpy."""
    name, text = _program(found, replaced)
    for line in (
        "import sys\n",
        "import threading\n",
        "import roslibpy\n",
        "threading.Event().wait()\n",
    ):
        assert line in text
        text = text.replace(line, "")
    ros = SimpleNamespace(run=lambda: None)
    roslibpy = SimpleNamespace(
        Ros=lambda *_, **__: ros,
        Topic=lambda _, *words: _Topic(transport, topics.Topic(*words)),
        Service=lambda _, *words: _Service(transport, topics.Service(*words)),
    )
    exec(compile(text.replace("sys.argv[1]", '""'), name, "exec"), {"roslibpy": roslibpy})


def _program(found: str, replaced: str) -> tuple[str, str]:
    """Return the simulator's name and text, with a text in it replaced."""
    (example,) = (block for block in blocks(PAGE.read_text(encoding="utf-8")) if block.file)
    text = "".join(f"{line}\n" for line in example.lines)
    assert found in text
    return example.file, text.replace(found, replaced) if found else text


@dataclass
class _Topic:
    """What stands for roslibpy's."""

    transport: topics.Transport
    topic: topics.Topic

    def advertise(self) -> None:
        self.publish = self.transport.advertise(self.topic)

    def subscribe(self, callback: Callable[[topics.Payload], None]) -> None:
        self.transport.subscribe(self.topic, callback)


@dataclass
class _Service:
    """What stands for roslibpy's."""

    transport: topics.Transport
    service: topics.Service

    def advertise(self, handler: Callable[[Any, topics.Payload], bool]) -> None:
        def provide(request: topics.Payload) -> topics.Payload:
            response: topics.Payload = {}
            handler(request, response)
            return response

        self.transport.provide(self.service, provide)
