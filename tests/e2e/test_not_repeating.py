"""A region that keeps state from flight to flight, reads a clock or draws unseeded numbers."""

import re

import pytest

from mrsfi_runtime.record.store import CampaignStore
from tests.support.cli import mrsfi, mrsfi_process, workspace
from tests.support.edited import COLLECTIVE, indented, write_body
from tests.tiers import night, slow

MISSION = "tight_margins"
REGIONS = {
    "a list of the module": ("SEEN = []", "SEEN.append(0)\nreturn len(SEEN) % 7 == 3"),
    "a mutable default": (
        "def counted(seen=[]):\n    seen.append(0)\n    return len(seen)",
        "return counted() % 7 == 3",
    ),
    "an attribute of a function": (
        "def counted():\n    counted.n += 1\n    return counted.n\n\n\ncounted.n = 0",
        "return counted() % 7 == 3",
    ),
    "what the first flight leaves": ("SEEN = []", "SEEN.append(0)\nreturn len(SEEN) < 9"),
    "a clock": ("import time", "return time.time_ns() % 7 == 3"),
    "unseeded random numbers": ("import random", "return random.random() < 0.1"),
}
FIRST = r"at tick \d+, is_(true|believed) of goal 'clear' \(region 'clear.check'\) is [01], then"
WHY = (
    "expected equal flights: look for a region that keeps state from flight to flight, reads a "
    "clock or draws unseeded random numbers"
)


def written(folder, kind):
    """Return a workspace with a region of that kind."""
    helpers, body = REGIONS[kind]
    place = workspace(folder, MISSION)
    path = place / "generated" / MISSION / COLLECTIVE
    write_body(path, "helpers", f"{helpers}\n")
    write_body(path, "clear.check", indented(body))
    return place


@pytest.mark.parametrize("kind", REGIONS)
def test_validate_refuses_a_mission_that_does_not_repeat_itself(tmp_path, kind):
    place = written(tmp_path, kind)

    told = mrsfi("validate", MISSION, cwd=place, expected=6).stdout

    line = rf"generated/{MISSION}:1: error: the mission does not repeat itself: {FIRST} [01]; "
    assert re.match(line + re.escape(f"{WHY} [MissionFlies]\n"), told)


@pytest.mark.parametrize(
    ("kind", "options"),
    [
        ("a list of the module", ("--workers", "1")),
        ("what the first flight leaves", ("--workers", "1")),
        ("a list of the module", ("--workers", "2")),
        *(
            pytest.param(kind, ("--workers", n, "--engine", "reference"), marks=mark)
            for kind in REGIONS
            for n, mark in (("1", slow), ("2", night))
        ),
        pytest.param("a list of the module", ("--workers", "2", "--dask", "local"), marks=night),
        pytest.param("a clock", ("--workers", "1", "--engine", "rosbridge"), marks=night),
    ],
)
def test_a_search_that_does_not_repeat_itself_ends_and_keeps_what_it_recorded(
    tmp_path, kind, options
):
    place = written(tmp_path, kind)
    evolve = ("evolve", MISSION, "--out", "r", "--evaluations", "4", "--population", "4")

    ended = mrsfi_process(*evolve, *options, cwd=place, expected=7)
    reported = mrsfi("report", "r", cwd=place)
    again = mrsfi("replay", "r", "--best", cwd=place, expected=7)

    counts = r"\d+ believed violations \(digest [0-9a-f]{8}…\)"
    seen = f"the mission does not repeat itself: evaluation [01] had {counts} and, once more at the"
    found = re.search(f"mrsfi: r: ({seen} end, {counts}; {FIRST} [01]; {WHY}); then", ended.stderr)
    assert found is not None, ended.stderr
    assert "harvest" not in ended.stderr
    assert f"caution   {found[1]}; results may be chance\n" in reported.stdout
    assert f"this campaign cannot be flown again: {found[1]}; " in again.stderr
    with CampaignStore.open(place / "r") as store:
        assert store.n_evaluations == 4


def test_what_compiles_and_does_not_repeat_itself_ends_before_anything_is_recorded(tmp_path):
    place = written(tmp_path, "unseeded random numbers")

    ended = mrsfi("evolve", MISSION, "--out", "r", cwd=place, expected=7)

    line = f"mrsfi: the mission does not repeat itself: {FIRST} [01]; {re.escape(WHY)}\n"
    assert re.fullmatch(line, ended.stderr)
    assert not (place / "r").exists()


def test_a_region_that_keeps_what_changes_nothing_repeats_itself(tmp_path):
    place = workspace(tmp_path, MISSION)
    path = place / "generated" / MISSION / COLLECTIVE
    write_body(path, "helpers", "KNOWN = {}\n")
    body = "tick = ci.mission.tick\nreturn KNOWN.setdefault(tick, tick % 7 == 3)"
    write_body(path, "clear.check", indented(body))
    evolve = ("evolve", MISSION, "--out", "r", "--evaluations", "4", "--population", "4")

    mrsfi("validate", MISSION, cwd=place)
    mrsfi(*evolve, "--workers", "1", "--no-explain", cwd=place)
