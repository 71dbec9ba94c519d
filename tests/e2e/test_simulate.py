import pytest

from mrsfi_runtime.engine import rosbridge
from mrsfi_runtime.model.mission import RESULTS
from tests.support.cli import MISSION, edit, mrsfi, mrsfi_json, stop_specification
from tests.tiers import slow


def test_a_hand_written_specification_is_flown(place):
    stop_specification(place / "models" / MISSION / "stop.xmi", [(100, 900)])

    flight = mrsfi_json("simulate", MISSION, "--faults", f"models/{MISSION}/stop.xmi", cwd=place)

    (fault,) = flight["faults"]
    changed = fault.pop("changed")
    assert 0 < changed <= 801
    assert fault == {
        "id": "h1",
        "type": "StopRobot",
        "target": "r1",
        "touched": ["r1 motion"],
        "start": 100,
        "finish": 900,
        "window": [100, 900],
        "values": {},
        "applied": 801,
    }
    assert any(goal["believed"] for goal in flight["goals"])
    assert all({*RESULTS} <= {*goal} for goal in flight["goals"])
    told = [(goal["missed"], goal["missed_since"]) for goal in flight["goals"]]
    assert any(missed for missed, _ in told)
    assert all(since == (1000 - missed if missed else None) for missed, since in told)
    assert all(goal["samples"] > 0 for goal in flight["goals"][3:])


def test_a_window_that_ends_beyond_the_mission_and_faults_of_no_pool_are_told(place):
    path = stop_specification(place / "models" / MISSION / "late.xmi", [(100, 200), (900, 1000)])
    edit(path, 'ID="h2"', 'ID="f30.2"')

    told = mrsfi("simulate", MISSION, "--faults", path, cwd=place).stderr.splitlines()

    assert f"{path}: not in the pool, flown as written: h1" in told
    (late,) = (line for line in told if "which ends beyond the mission" in line)
    assert late.startswith(f"{path}: fault 'f30.2' has the window 900 … 1000, ")
    assert len(told) == 2


@pytest.mark.parametrize("command", ["simulate", "explain"])
@pytest.mark.parametrize(
    "windows",
    [[(100, 200), (150, 300)], [None]],
    ids=["overlap", "no window"],
)
def test_a_specification_that_cannot_be_flown_ends_with_5(windows, command, place, approved):
    path = stop_specification(place / "models" / MISSION / "bad.xmi", windows)

    error = mrsfi(command, MISSION, "--faults", path, cwd=place, expected=5).stderr

    approved(error)


COPY = """<faults ID="f7.{n}" name="f7" start="{start}" finish="50"><decrementSpeed VAL="1">
<affectedMessage href="mission.xmi#m1"/></decrementSpeed></faults>"""


def test_overlapping_copies_of_one_fault_end_with_5_even_if_they_touch_nothing(place, approved):
    path = place / "models" / MISSION / "twice.xmi"
    copies = "".join(COPY.format(n=n, start=start) for n, start in ((1, 29), (2, 30)))
    path.write_text(
        '<faults:FaultSpecification xmi:version="2.0" xmlns:xmi="http://www.omg.org/XMI" '
        f'xmlns:faults="http://mrsfi.org/faults/1.0" ID="s">{copies}</faults:FaultSpecification>'
    )

    error = mrsfi("simulate", MISSION, "--faults", path, cwd=place, expected=5).stderr

    approved(error)


@slow
def test_auto_opens_no_server(place, monkeypatch):
    monkeypatch.setattr(rosbridge, "RosbridgeEngine", None)

    mrsfi("simulate", MISSION, "--engine", "auto", cwd=place)
