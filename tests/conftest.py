"""What holds for all tests: hypothesis' profiles, one cache, and what the quick rooms refuse."""

import os
import signal
import socket
import subprocess
from collections.abc import Iterator
from multiprocessing.process import BaseProcess
from typing import Any, NoReturn

import pytest
from hypothesis import settings

from tests.support.tree import ROOT
from tests.tiers import EXAMPLES, QUICK

pytest_plugins = ("tests.support.approved",)

# Hundreds of processes begin in the tests; each would compile every module that it imports.
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
os.environ.pop("COLUMNS", None)  # tables are as wide as in any pipe, whoever runs the tests
os.environ.setdefault("MRSFI_CACHE", str(ROOT / ".pytest_cache" / "mrsfi"))

if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:  # as in a shell's background, and inherited
    signal.signal(signal.SIGINT, signal.default_int_handler)

for _name, _percent in EXAMPLES.items():
    settings.register_profile(_name, settings(), max_examples=_percent, deadline=None)
settings.load_profile("test")


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_setup() -> None:
    os.environ.pop("MRSFI_METAMODELS", None)  # a test before it may have loaded as a script does


@pytest.fixture(autouse=True)
def _no_process_no_socket(request: pytest.FixtureRequest) -> Iterator[None]:
    """Fail a test of a quick room that starts a process or opens a socket."""
    room = request.path.relative_to(ROOT / "tests").parts[0]

    def refuse(*_: Any, **__: Any) -> NoReturn:
        pytest.fail(f"a test of tests/{room} starts a process or opens a socket: move it")

    with pytest.MonkeyPatch.context() as patches:
        if room in QUICK:
            patches.setattr(BaseProcess, "start", refuse)
            for owner in (subprocess.Popen, socket.socket):
                patches.setattr(owner, "__init__", refuse)
            for name in ("fork", "posix_spawn", "system"):
                patches.setattr(os, name, refuse)
        yield
