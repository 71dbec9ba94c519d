from pathlib import Path

import pytest

from mrsfi_runtime import files
from mrsfi_runtime.errors import RecordError
from mrsfi_runtime.study.comparison import as_json
from mrsfi_runtime.study.folder import ComparisonFolder
from tests.support.comparisons import compared, new_folder


@pytest.fixture
def folder(tmp_path: Path) -> ComparisonFolder:
    return new_folder(tmp_path)


def test_a_write_that_fails_leaves_the_old_file_and_nothing_else(folder, monkeypatch, refused):
    table = folder.path / "runs.csv"
    table.write_text("before")

    def full(_: int) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(files.os, "fsync", full)
    comparison = compared()
    with refused(RecordError):
        folder.write(comparison, as_json(comparison))

    assert table.read_text() == "before"
    assert sorted(file.name for file in folder.path.iterdir()) == ["runs", "runs.csv"]


def test_a_folder_that_cannot_be_written_is_told(tmp_path, refused):
    comparison = compared()

    with refused(RecordError):
        ComparisonFolder(tmp_path / "gone").write(comparison, as_json(comparison))


@pytest.mark.parametrize("other", ["runs", "campaign.lock"])
def test_a_folder_is_a_comparison_by_its_lock_and_runs(folder, other, refused):
    folder.lock.touch()

    assert ComparisonFolder.reserve(folder.path).path == folder.path

    (folder.path / other).rename(folder.path / "other")
    with refused(RecordError):
        ComparisonFolder.reserve(folder.path)
