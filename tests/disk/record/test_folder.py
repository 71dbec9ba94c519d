from pathlib import Path

import pytest

from mrsfi_runtime.errors import RecordError
from mrsfi_runtime.record.database import CampaignFolder


@pytest.fixture
def sources(tmp_path: Path) -> tuple[Path, Path]:
    models, generated = tmp_path / "models", tmp_path / "generated"
    (generated / "__pycache__").mkdir(parents=True)
    models.mkdir()
    (models / "mission.xmi").write_bytes(b"<mission/>\r\n")
    (models / "case_a.toml").write_text("seed = 1\n")
    (generated / "simulation.py").write_text("x = 1\n")
    (generated / "__pycache__" / "simulation.pyc").write_bytes(b"old")
    return models, generated


def test_models_and_generated_code_are_copied_byte_for_byte_without_caches(sources, tmp_path):
    folder = CampaignFolder.reserve(tmp_path / "runs" / "first")
    folder.fill(*sources)

    files = {
        file.relative_to(folder.path).as_posix(): file.read_bytes()
        for file in folder.path.rglob("*")
        if file.is_file()
    }
    assert files == {
        "model/mission.xmi": b"<mission/>\r\n",
        "model/case_a.toml": b"seed = 1\n",
        "generated/simulation.py": b"x = 1\n",
    }


def test_an_empty_folder_is_used(sources, tmp_path):
    (tmp_path / "run").mkdir()

    folder = CampaignFolder.reserve(tmp_path / "run")
    folder.fill(*sources)

    assert folder.model.is_dir()


@pytest.mark.parametrize("name", ["run/note.txt", "run"])
def test_what_is_there_already_is_refused_and_left_alone(tmp_path, name, refused):
    (tmp_path / name).parent.mkdir(exist_ok=True)
    (tmp_path / name).write_text("mine")

    with refused(RecordError):
        CampaignFolder.reserve(tmp_path / "run")

    assert (tmp_path / name).read_text() == "mine"


def test_what_a_killed_start_left_is_replaced(sources, tmp_path):
    path = tmp_path / "run"
    (path / "model").mkdir(parents=True)
    for name in ("model/mission.xmi", "campaign.lock", "campaign.sqlite.new"):
        (path / name).write_text("half")

    CampaignFolder.reserve(path).fill(*sources)

    assert (path / "model" / "mission.xmi").read_bytes() == b"<mission/>\r\n"
    assert (path / "generated" / "simulation.py").is_file()


@pytest.mark.parametrize("name", ["campaign.sqlite", "notes.txt"])
def test_a_folder_that_somebody_filled_since_it_was_reserved_is_left_alone(
    sources, tmp_path, name, refused
):
    folder = CampaignFolder.reserve(tmp_path / "run")
    (folder.path / "campaign.lock").touch()
    (folder.path / name).write_text("theirs")

    with refused(RecordError):
        folder.fill(*sources)

    assert sorted(entry.name for entry in folder.path.iterdir()) == ["campaign.lock", name]


def test_missing_models_are_refused_with_the_path(tmp_path, refused):
    with refused(RecordError):
        CampaignFolder.reserve(tmp_path / "run").fill(tmp_path / "nowhere", tmp_path)
