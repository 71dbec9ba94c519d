"""Tiers, the guard of the quick rooms, times, and one folder for what tests compile."""

import os
import signal
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from hypothesis import settings

from tests.guard import guard
from tests.support.tree import ROOT
from tests.tiers import FILELESS, N_TURNS, TIERS, turn
from tests.timing import Timing

# Hundreds of processes begin in the tests; each would compile every module that it imports.
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
os.environ.pop("COLUMNS", None)  # tables are as wide as in any pipe, whoever runs the tests
os.environ.setdefault("MRSFI_CACHE", str(ROOT / ".pytest_cache" / "mrsfi"))

_LEFT = pytest.StashKey[Counter[str]]()
"""How many tests of each file have their turn on another day."""

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
    config.addinivalue_line("markers", "early: begins before all others, for it takes longest")
    config.addinivalue_line("markers", "turn: which of its days make test-all takes it")
    config.pluginmanager.register(Timing())
    config.stash[_LEFT] = Counter()


def pytest_report_header(config: pytest.Config) -> str:
    tier = config.getoption("--tier")
    day = f"; day {turn() + 1} of {N_TURNS}" if TIERS[tier].takes_turns else ""
    return f"tier: {tier}{day} (tests/tiers.py; --tier all leaves out nothing)"


def pytest_ignore_collect(collection_path: Path, config: pytest.Config) -> bool | None:
    rooms = TIERS[config.getoption("--tier")].rooms
    room = _room(collection_path)
    is_left_out = collection_path.is_dir() and rooms and room and room not in rooms
    return True if is_left_out else None


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    tier = TIERS[config.getoption("--tier")]
    today = turn() if tier.takes_turns else 0
    others = [item for item in items if tier.takes(item) and tier.leaves(item, today)]
    taken = [item for item in items if tier.takes(item) and not tier.leaves(item, today)]
    config.stash[_LEFT].update(item.nodeid.partition("::")[0] for item in others)
    kept = {*taken}
    config.hook.pytest_deselected(items=[item for item in items if item not in kept])
    items[:] = sorted(taken, key=lambda item: item.get_closest_marker("early") is None)


@pytest.hookimpl(wrapper=True)
def pytest_sessionfinish(session: pytest.Session) -> Iterator[None]:
    if hasattr(session.config, "workeroutput"):
        session.config.workeroutput["left"] = dict(session.config.stash[_LEFT])
    return (yield)


@pytest.hookimpl(optionalhook=True)
def pytest_testnodedown(node: Any) -> None:
    """Take over from a worker what it has left; each has collected all of it."""
    node.config.stash[_LEFT] |= Counter(getattr(node, "workeroutput", {}).get("left", {}))


def pytest_terminal_summary(
    terminalreporter: pytest.TerminalReporter, config: pytest.Config
) -> None:
    """Name what has its turn on another day."""
    left = config.stash[_LEFT]
    if left:
        terminalreporter.section(f"{left.total():,} tests left to other days and make test-night")
    for file, n in left.most_common():
        terminalreporter.write_line(f"{n:8,}  {file}")


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
