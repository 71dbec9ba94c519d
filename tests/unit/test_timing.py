"""What the end of a run says of its time."""

from types import SimpleNamespace

from tests.timing import Timing


class Reporter:
    def __init__(self):
        self.lines = []

    def section(self, title):
        self.lines.append(title)

    def write_line(self, line):
        self.lines.append(line)


def report(test, seconds, work):
    return SimpleNamespace(nodeid=test, duration=seconds, busy=work)


def test_rooms_are_summed_and_the_slowest_tests_named():
    timing, reporter = Timing(), Reporter()
    for phase in (0.5, 1.0):  # set-up and call
        timing.pytest_runtest_logreport(report("tests/unit/a/test_b.py::test_c", phase, 0.25))
    timing.pytest_runtest_logreport(report("tests/unit/test_d.py::test_e", 4.0, 2.0))
    timing.pytest_runtest_logreport(report("tests/model/test_f.py::test_g[1/2]", 2.0, 0.0))

    timing.pytest_terminal_summary(reporter)

    lines = [" ".join(line.split()) for line in reporter.lines]
    assert "2.0 0.0 tests/model (1 tests)" in lines
    assert "5.5 2.5 tests/unit (2 tests)" in lines
    assert "7.5 2.5 all tests, one after the other" in lines
    assert lines[-3:] == [
        "4.0 2.0 tests/unit/test_d.py::test_e",
        "2.0 0.0 tests/model/test_f.py::test_g[1/2]",
        "1.5 0.5 tests/unit/a/test_b.py::test_c",
    ]


def test_a_run_without_tests_says_nothing():
    reporter = Reporter()

    Timing().pytest_terminal_summary(reporter)

    assert reporter.lines == []
