"""Figures of the conformance suite, printed at the end of its run."""

from collections.abc import Callable
from itertools import chain

import pytest

from tests.interop.eclipse import Note, missing

_COMPARED = "compared"
"""Name under which a test reports its figures, from whichever process it runs in."""


@pytest.fixture
def note(record_property: Callable[[str, object], None]) -> Note:
    """Keep figures until the end of the run."""

    def add(part: str, **counts: int) -> None:
        figures = ", ".join(f"{count:,} {name.replace('_', ' ')}" for name, count in counts.items())
        record_property(_COMPARED, f"{part}: {figures}")

    return add


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    reports = [
        report
        for reports in terminalreporter.stats.values()
        for report in reports
        if isinstance(report, pytest.TestReport) and report.when == "call"
    ]
    properties = chain.from_iterable(report.user_properties for report in reports)
    lines = sorted(str(line) for name, line in properties if name == _COMPARED)
    if reports and not lines and missing():
        lines = [f"nothing was compared: {missing()}"]
    if lines:
        terminalreporter.section("Compared with the real thing")
        for line in lines:
            terminalreporter.write_line(line)
