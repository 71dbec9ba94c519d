"""Tiers, the guard of the quick rooms, times, and one folder for what tests compile."""

import os
import signal
from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import settings

from tests.guard import guard
from tests.support.tree import ROOT
from tests.tiers import FILELESS, TIERS
from tests.timing import Timing

# Hundreds of processes begin in the tests; each would compile every module that it imports.
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
os.environ.setdefault("MRSFI_CACHE", str(ROOT / ".pytest_cache" / "mrsfi"))

if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:  # as in a shell's background, and inherited
    signal.signal(signal.SIGINT, signal.default_int_handler)


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--tier", choices=[*TIERS], default="test", help="see tests/tiers.py")


def pytest_configure(config: pytest.Config) -> None:
    """Load the tier's number of examples before any test module states its laws."""
    name = config.getoption("--tier")
    settings.register_profile(name, settings(), max_examples=TIERS[name].examples, deadline=None)
    settings.load_profile(name)
    config.addinivalue_line("markers", "slow: left to make test-all")
    config.pluginmanager.register(Timing())


def pytest_report_header(config: pytest.Config) -> str:
    return f"tier: {config.getoption('--tier')} (tests/tiers.py; --tier all leaves out nothing)"


def pytest_ignore_collect(collection_path: Path, config: pytest.Config) -> bool | None:
    rooms = TIERS[config.getoption("--tier")].rooms
    room = _room(collection_path)
    is_left_out = collection_path.is_dir() and rooms and room and room not in rooms
    return True if is_left_out else None


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    tier = TIERS[config.getoption("--tier")]
    left_out = [item for item in items if not tier.takes(item)]
    config.hook.pytest_deselected(items=left_out)
    items[:] = [item for item in items if tier.takes(item)]


@pytest.fixture(autouse=True)
def width_of_a_pipe(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let tables be as wide as in any pipe: whoever runs the tests may have COLUMNS."""
    monkeypatch.delenv("COLUMNS", raising=False)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_setup(item: pytest.Function) -> Iterator[None]:
    os.environ.pop("MRSFI_METAMODELS", None)  # a test before it may have loaded as a script does
    room = _room(item.path)
    if room in FILELESS and "tmp_path" in item.fixturenames:
        pytest.fail(f"a test of tests/{room} has a folder: move it to tests/disk", pytrace=False)
    with guard(room, is_writing_allowed=True):
        return (yield)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_call(item: pytest.Item) -> Iterator[None]:
    with guard(_room(item.path)):
        return (yield)


def _room(path: Path) -> str:
    parts = path.relative_to(ROOT / "tests").parts
    return parts[0] if parts else ""
