from pathlib import Path

import pytest

from mrsfi_runtime.errors import RecordError
from mrsfi_runtime.study import folder as study_folder
from mrsfi_runtime.study.comparison import as_json
from mrsfi_runtime.study.folder import ComparisonFolder
from tests.support.comparisons import compared, new_folder, result

SUBJECT = {"population": 20, "evaluations": 40, "goals": ["g1", "g3"]}


@pytest.fixture
def folder(tmp_path: Path) -> ComparisonFolder:
    return new_folder(tmp_path)


def test_a_finished_run_is_found_again(folder):
    run = result("my.own:search", 7)

    folder.keep(run, SUBJECT)

    assert folder.kept("my.own:search", 7, SUBJECT) == run
    assert folder.kept("my.own:search", 8, SUBJECT) is None
    assert [file.name for file in folder.runs.iterdir()] == ["my.own:search-7.json"]


def test_a_run_of_something_else_is_refused_and_says_what_differs(folder):
    folder.keep(result("paper", 1), SUBJECT)

    with pytest.raises(
        RecordError, match=r"paper-1\.json: .*evaluations 40; expected .* 50; .*--out"
    ):
        folder.kept("paper", 1, SUBJECT | {"evaluations": 50})


@pytest.mark.parametrize(
    "text", ["", "{", "[]", "{}", '{"schema": 1, "subject": {}, "result": {}}', "null"]
)
def test_a_damaged_run_is_refused_by_name(folder, text):
    folder.run_file("paper", 1).write_text(text)

    with pytest.raises(RecordError, match=r"paper-1\.json: is not the result of a run.*remove"):
        folder.kept("paper", 1, SUBJECT)


def test_a_run_under_a_wrong_name_is_refused(folder):
    folder.keep(result("paper", 1), SUBJECT)
    folder.run_file("paper", 1).rename(folder.run_file("paper", 2))

    with pytest.raises(RecordError, match="another schema or run"):
        folder.kept("paper", 2, SUBJECT)


def test_a_write_that_fails_leaves_the_old_file_and_nothing_else(folder, monkeypatch):
    run = result("paper", 1)
    folder.keep(run, SUBJECT)

    def full(_: int) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(study_folder.os, "fsync", full)
    with pytest.raises(RecordError, match="No space left on device"):
        folder.keep(run, SUBJECT | {"evaluations": 50})

    assert folder.kept("paper", 1, SUBJECT) == run
    assert len(list(folder.runs.iterdir())) == 1


def test_what_a_kill_left_is_removed(folder):
    left = folder.path / "unfinished-x"
    left.mkdir()
    (left / "campaign.sqlite").write_bytes(b"x")
    folder.keep(result("paper", 1), SUBJECT)

    folder.tidy()

    assert [file.name for file in folder.path.iterdir()] == ["runs"]


def test_a_folder_that_cannot_be_written_is_told(tmp_path):
    comparison = compared()

    with pytest.raises(RecordError, match="cannot be written"):
        ComparisonFolder(tmp_path / "gone").write(comparison, as_json(comparison))
