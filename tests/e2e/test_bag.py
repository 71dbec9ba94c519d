"""Bags that commands write."""

import pytest

from tests.support.bags import read_bag
from tests.support.cli import MISSION, edit, mrsfi, stop_specification
from tests.tiers import slow


@slow
def test_simulate_and_replay_write_the_bag_of_a_flight(flown, place, tmp_path):
    stop = f"models/{MISSION}/stop.xmi"
    stop_specification(place / stop, [(100, 200)])

    done = mrsfi("simulate", MISSION, "--faults", stop, "--mcap", "b.mcap", cwd=place)
    mrsfi("replay", flown, "--best", "--mcap", tmp_path / "best.mcap", cwd=tmp_path)

    assert "written    b.mcap" in done.stderr
    events = [message.msg for _, message in read_bag(place / "b.mcap")["/rosout"]]
    assert "fault h1 StopRobot on r1 motion: starts (100 … 200)" in events
    assert "/markers" in read_bag(tmp_path / "best.mcap")


@pytest.mark.parametrize("name", ["b.mcap", "page.html"])
def test_a_flight_that_fails_on_its_way_leaves_the_file_of_before(name, place):
    begin = "    # protected region g3.check on begin\n"
    failing = f"{begin}    if ci.mission.tick == 50:\n        raise ValueError('seen')\n"
    edit(place / "generated" / MISSION / "collective_intelligence.py", begin, failing)
    (place / name).write_text("of before")
    recorded = (f"--{name.partition('.')[2]}", name, "--trace", "t.csv")

    done = mrsfi("simulate", MISSION, "--engine", "reference", *recorded, cwd=place, expected=6)

    assert "seen" in done.stderr
    assert len((place / "t.csv").read_text().splitlines()) > 40  # it flew until then
    assert (place / name).read_text() == "of before"
    assert not [*place.glob(".*.new")]
