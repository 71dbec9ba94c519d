from pathlib import Path

import pytest

from mrsfi.folders import find_mission
from tests.support.cli import MISSION


@pytest.fixture
def here(place: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(place)
    return place


@pytest.mark.parametrize("mission", [MISSION, f"models/{MISSION}", f"models/{MISSION}/"])
def test_a_name_and_a_path_lead_to_the_same_folders(mission, here):
    found = find_mission(mission)

    assert found.name == MISSION
    assert found.models.resolve() == here / "models" / MISSION
    assert found.generated == Path("generated") / MISSION


def test_a_mission_outside_models_has_its_code_beside_it(here, tmp_path):
    (here / "models" / MISSION).rename(tmp_path / "harbour")

    assert find_mission("harbour").generated == Path("generated/harbour")


def test_inside_the_mission_folder_a_dot_is_enough(here, monkeypatch):
    monkeypatch.chdir(here / "models" / MISSION)

    found = find_mission(".")

    assert found.name == MISSION
    assert found.generated == Path("..", "..", "generated", MISSION)
