"""Figures of the conformance suite, printed at the end of its run."""

import pytest

from tests.interop.eclipse import Note, missing

_LINES = pytest.StashKey[list[str]]()


def pytest_configure(config: pytest.Config) -> None:
    config.stash[_LINES] = []


@pytest.fixture(scope="session")
def note(pytestconfig: pytest.Config) -> Note:
    """Keep figures until the end of the run."""

    def add(part: str, **counts: int) -> None:
        figures = ", ".join(f"{count:,} {name.replace('_', ' ')}" for name, count in counts.items())
        pytestconfig.stash[_LINES].append(f"{part}: {figures}")

    return add


def pytest_terminal_summary(
    terminalreporter: pytest.TerminalReporter, config: pytest.Config
) -> None:
    lines = sorted(config.stash[_LINES])
    if not lines and missing():
        lines = [f"nothing was compared: {missing()}"]
    if lines:
        terminalreporter.section("Compared with the real thing")
        for line in lines:
            terminalreporter.write_line(line)
