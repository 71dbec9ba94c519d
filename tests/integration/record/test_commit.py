"""The date and the commit that the record of a campaign keeps."""

import subprocess
from datetime import UTC, datetime

import pytest

from mrsfi.evolving import commit_of, made
from mrsfi.folders import folders_at
from mrsfi_runtime.record.engine_settings import EngineSettings
from mrsfi_runtime.record.settings import CampaignSettings
from mrsfi_runtime.record.store import CampaignStore
from tests.support.rendezvous import NAME, write_rendezvous


def git(place, *words):
    who = ("-c", "user.name=A", "-c", "user.email=a@b")
    line = ("git", "-C", place, *who, *words)
    done = subprocess.run(line, check=True, capture_output=True, encoding="utf-8")
    return done.stdout.strip()


@pytest.fixture
def folders(tmp_path):
    """Folders of a mission that git has."""
    write_rendezvous(tmp_path)
    git(tmp_path, "init", "-q")
    git(tmp_path, "add", ".")
    git(tmp_path, "commit", "-qm", "First")
    return folders_at(tmp_path / "models" / NAME)


def test_a_new_campaign_records_when_it_was_made_and_from_which_commit(folders, tmp_path):
    then = datetime(2026, 11, 28, 9, 15, 2, tzinfo=UTC)

    with made(tmp_path / "run", folders, CampaignSettings(), "a", EngineSettings(), lambda: then):
        pass

    with CampaignStore.open(tmp_path / "run") as store:
        found = store.manifest
    assert found.created == "2026-11-28T09:15:02.000+00:00"
    assert (found.commit, found.is_edited) == (git(tmp_path, "rev-parse", "HEAD"), False)


@pytest.mark.parametrize("place", ["models", "generated"])
def test_a_change_of_models_or_code_is_recorded_and_one_of_other_files_is_not(folders, place):
    (folders.models.parent.parent / "notes.md").touch()
    before = commit_of(folders)

    (getattr(folders, place) / "more.py").touch()

    assert before == (before[0], False)
    assert commit_of(folders) == (before[0], True)


def test_a_new_mission_differs_from_the_commit_and_without_git_none_is_recorded(
    tmp_path, monkeypatch, folders
):
    other = tmp_path / "models" / "other"
    write_rendezvous(tmp_path / "new")
    (tmp_path / "new" / "models" / NAME).rename(other)

    assert commit_of(folders_at(other)) == (commit_of(folders)[0], True)
    assert commit_of(folders_at(tmp_path.parent)) == ("", False)
    monkeypatch.setenv("PATH", "")
    assert commit_of(folders) == ("", False)
