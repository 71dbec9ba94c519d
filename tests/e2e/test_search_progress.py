import re
from collections.abc import Iterator
from types import SimpleNamespace

import pytest

from mrsfi_runtime.cli import terminal
from mrsfi_runtime.cli.terminal import flight_progress, plain_lines, share_done
from mrsfi_runtime.record.settings import CampaignSettings
from mrsfi_runtime.search.run import CampaignProgress
from tests.support.cli import MISSION, mrsfi


def state(generation: int, n_evaluations: int = 0, n_failures: int = 0) -> CampaignProgress:
    return CampaignProgress(
        generation=generation,
        best=12.0,
        mean=3.456,
        n_evaluations=n_evaluations,
        n_failures=n_failures,
    )


def ticking(seconds: float) -> Iterator[float]:
    now = 0.0
    while True:
        yield now
        now += seconds


@pytest.mark.parametrize(
    ("settings", "at", "share"),
    [
        (CampaignSettings(generations=0), state(0), 1.0),
        (CampaignSettings(generations=3), state(0), 0.25),
        (CampaignSettings(generations=3), state(3), 1.0),
        (CampaignSettings(evaluations=40), state(7, n_evaluations=9, n_failures=1), 0.25),
    ],
)
def test_share_done_counts_generations_or_evaluations(settings, at, share):
    assert share_done(settings, at) == share


@pytest.mark.parametrize(
    ("settings", "seconds", "begun", "at", "printed"),
    [
        (
            CampaignSettings(generations=1),
            65.0,
            0.0,
            state(0, n_evaluations=20),
            "generation 0/1  best 12.00  mean 3.46  evaluations 20  left 1:05\n",
        ),
        (
            CampaignSettings(generations=9),
            60.0,
            0.7,  # what was recorded before does not count into the time left
            state(7, n_evaluations=90),
            "generation 7/9  best 12.00  mean 3.46  evaluations 90  left 2:00\n",
        ),
        (CampaignSettings(evaluations=100), 0.0, 0.5, state(7, n_evaluations=50), ""),
    ],
    ids=["begun", "resumed", "recorded before"],
)
def test_a_line_has_generation_best_mean_and_time_left(
    capfd, settings, seconds, begun, at, printed
):
    clock = ticking(seconds)

    plain_lines(settings, lambda: next(clock), begun=begun)(at)

    assert capfd.readouterr() == ("", printed)


def test_a_long_search_prints_some_hundred_lines_and_always_the_last(capfd):
    clock = ticking(1.0)
    lines = plain_lines(CampaignSettings(generations=5000), lambda: next(clock))

    for generation in range(5001):
        lines(state(generation))

    printed = capfd.readouterr().err.splitlines()
    assert 90 <= len(printed) <= 102
    assert printed[-1].startswith("generation 5000/5000")


def test_the_time_left_follows_a_search_that_became_faster(capfd):
    clock = iter([0.0, *(100.0 * k for k in range(1, 11)), *(1000.0 + k for k in range(1, 11))])
    lines = plain_lines(CampaignSettings(generations=49), lambda: next(clock))

    for generation in range(20):
        lines(state(generation))

    printed = capfd.readouterr().err.splitlines()
    assert printed[9].endswith("left 66:40")
    assert printed[19].endswith("left 0:30")


def test_a_long_flight_tells_now_and_then_how_far_it_is(place, monkeypatch):
    quiet = mrsfi("simulate", MISSION, cwd=place)
    monkeypatch.setattr(terminal, "_EVERY", 0.0)

    telling = mrsfi("simulate", MISSION, cwd=place)

    assert quiet.stderr == ""
    lines = telling.stderr.splitlines()
    assert len(lines) == 1000
    assert all(re.fullmatch(r"tick [\d,]+ of 1,000  left 0:\d\d", line) for line in lines)
    assert lines[-1] == "tick 1,000 of 1,000  left 0:00"
    assert telling.stdout == quiet.stdout


def test_the_time_left_of_a_flight_follows_from_its_pace(capfd):
    clock = ticking(10.0)
    lines = flight_progress(4, lambda: next(clock))

    lines(SimpleNamespace(mission=SimpleNamespace(tick=0)))

    assert capfd.readouterr() == ("", "tick 1 of 4  left 0:30\n")
