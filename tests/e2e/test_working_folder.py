"""Users' code that changes the working folder moves no output: it lands where the command says."""

import pytest

import mrsfi as api
from tests.support.cli import mrsfi
from tests.support.edited import COLLECTIVE, indented, write_body
from tests.support.rendezvous import NAME, write_rendezvous

CHECK = "os.chdir(AWAY)\nreturn goal_tasks.visit.violated(ci, G1)"


@pytest.fixture
def moving(tmp_path):
    """Folder of a small mission, and the one to which its code goes: as it is read, and flown."""
    place, away = tmp_path / "place", tmp_path / "away"
    away.mkdir()
    code = write_rendezvous(place) / COLLECTIVE
    write_body(code, "helpers", f"import os\n\nAWAY = {str(away)!r}\nos.chdir(AWAY)\n")
    write_body(code, "g1.check", indented(CHECK))
    return place, away


FLIGHT = ("flight.log", "flight.csv", "flight.mcap", "flight.html")
FILES = [word for name in FLIGHT for word in (f"--{name[7:].replace('csv', 'trace')}", name)]


def test_files_of_a_flight_are_written_where_the_command_was_called(moving):
    place, away = moving

    mrsfi("simulate", NAME, *FILES, cwd=place)

    assert {path.name for path in place.iterdir()} == {"models", "generated", *FLIGHT}
    assert [*away.iterdir()] == []


def test_the_api_writes_where_the_script_runs(moving, monkeypatch):
    place, away = moving
    monkeypatch.chdir(place)
    mission = api.load(NAME)

    flight = mission.fly((), engine="reference")
    campaign = mission.evolve(
        out="runs/it", engine="reference", workers=1, population=4, generations=0, explain=False
    )
    campaign.pack("it.zip")

    assert flight.outcome.believed == (0, 0, 0)
    assert (place / "it.zip").is_file()
    assert [*away.iterdir()] == []
