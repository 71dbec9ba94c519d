"""How long the rooms of the tests took, and the slowest tests, at the end of a run.

Two figures each: seconds by the clock, and seconds that this processor worked for it, processes
that a test started and waited for included. The second hardly depends on what else runs.
"""

import os
import time
from collections import defaultdict
from collections.abc import Iterator

import pytest

N_SLOWEST = 10


def busy() -> float:
    """Return the processor seconds of this process and of its children that have ended."""
    times = os.times()
    return times.user + times.system + times.children_user + times.children_system


class Timing:
    """Plugin that measures in every worker, and tells at the end of the run."""

    def __init__(self) -> None:
        self.began = time.monotonic()
        self.busy = busy()
        self.clock: dict[str, float] = defaultdict(float)
        self.work: dict[str, float] = defaultdict(float)

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtest_logstart(self) -> None:
        self.busy = busy()

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_makereport(self) -> Iterator[None]:
        report = yield
        now = busy()
        report.busy, self.busy = now - self.busy, now
        return report

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        self.clock[report.nodeid] += report.duration
        self.work[report.nodeid] += getattr(report, "busy", 0.0)

    def pytest_terminal_summary(self, terminalreporter: pytest.TerminalReporter) -> None:
        if not self.clock:
            return
        terminalreporter.section("seconds by the clock, and of work")
        rooms: dict[str, list[str]] = defaultdict(list)
        for test in self.clock:
            rooms["/".join(test.split("/", 2)[:2]).partition("::")[0]].append(test)
        for room, tests in sorted(rooms.items()):
            self._line(terminalreporter, f"{room} ({len(tests):,} tests)", tests)
        self._line(terminalreporter, "all tests, one after the other", list(self.clock))
        took = time.monotonic() - self.began
        terminalreporter.write_line(f"{took:8.1f}           the whole run")
        terminalreporter.section(f"the {N_SLOWEST} slowest tests")
        for test in sorted(self.clock, key=self.clock.__getitem__, reverse=True)[:N_SLOWEST]:
            self._line(terminalreporter, test, [test])

    def _line(self, reporter: pytest.TerminalReporter, title: str, tests: list[str]) -> None:
        clock, work = (sum(map(kept.__getitem__, tests)) for kept in (self.clock, self.work))
        reporter.write_line(f"{clock:8.1f} {work:8.1f}  {title}")
