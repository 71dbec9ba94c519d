"""Several files as one change: all of it or nothing, whatever comes in between."""

import errno
import os
import shutil
from itertools import count

import pytest

from mrsfi_runtime import files
from mrsfi_runtime.errors import UsageError
from mrsfi_runtime.files import (
    JOURNAL,
    changing,
    settle,
    whole_file,
    whole_folder,
    write_atomically,
)
from tests.support.crashes import crash_after


@pytest.fixture
def place(tmp_path):
    folder = tmp_path / "mission"
    for name in ("a.xmi", "code/b.py", "code/gone.py"):
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text("old")
    return folder


OLD = {"a.xmi": "old", "code/b.py": "old", "code/gone.py": "old"}
NEW = {"a.xmi": "new", "code/b.py": "new", "kept/c.toml": "new"}


def change(place):
    with changing(place) as found:
        gone = {place / name: None for name in OLD if name not in NEW}
        found.replace({place / name: text.encode() for name, text in NEW.items()} | gone)


def standing(place):
    return {
        str(path.relative_to(place)): path.read_text()
        for path in place.rglob("*")
        if path.is_file()
    }


def test_a_change_is_whole_and_leaves_nothing_else(place, capsys):
    (place / "a.xmi").chmod(0o640)

    change(place)

    assert standing(place) == NEW
    assert (place / "a.xmi").stat().st_mode & 0o777 == 0o640
    assert capsys.readouterr().err == ""


def test_whoever_comes_after_a_crash_finds_all_or_nothing(place, tmp_path, capsys):
    for step in count():
        folder = tmp_path / f"{step}"
        place.rename(folder)
        with crash_after(step):
            change(folder)
        is_over = standing(folder) == NEW

        settle(folder)

        found, told = standing(folder), capsys.readouterr().err
        assert found in (OLD, NEW)
        assert told == "" or ("undid" if found == OLD else "finished") in told
        if is_over:
            break
        change(folder)
        assert standing(folder) == NEW
        for name, text in OLD.items():
            (folder / name).write_text(text)
        (folder / "kept" / "c.toml").unlink()
        folder.rename(place)
    assert step > 15


@pytest.mark.parametrize("first", [8, 14, 16])
def test_a_crash_of_what_mends_is_mended_too(place, tmp_path, first):
    with crash_after(first):
        change(place)
    for step in range(12):
        with crash_after(step):
            settle(place)

    settle(place)

    assert standing(place) in (OLD, NEW)


def _in_the_way(place, _):
    (place / "kept").mkdir()
    (place / "kept" / "c.toml").mkdir()


def _full(_, monkeypatch):
    calls, genuine = count(), os.fsync

    def fsync(descriptor):
        if next(calls) == 4:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        genuine(descriptor)

    monkeypatch.setattr(os, "fsync", fsync)


def _too_long(place, monkeypatch):
    monkeypatch.setitem(NEW, f"{'x' * 300}.xmi", "new")


@pytest.mark.parametrize(
    "spoil",
    [_in_the_way, _full, _too_long],
)
def test_where_one_cannot_be_written_all_stay(place, monkeypatch, spoil, refused):
    spoil(place, monkeypatch)

    with refused(UsageError):
        change(place)

    assert standing(place) == OLD


def test_an_interrupt_leaves_all_or_nothing_at_once(place, tmp_path):
    for step in count():
        folder = tmp_path / f"{step}"
        shutil.copytree(place, folder)
        with crash_after(step, is_lasting=False):
            change(folder)

        assert (folder / JOURNAL).exists() <= (step < 2)
        settle(folder)
        assert standing(folder) in (OLD, NEW)
        if standing(folder) == NEW:
            break
    assert step > 10


def test_what_was_edited_between_kill_and_mending_is_kept(place, capsys):
    for step in count(12):
        with crash_after(step):
            change(place)
        if (place / "a.xmi").read_text() == "new":
            break
    (place / "code" / "b.py").write_text("by hand")

    settle(place)

    assert standing(place) == NEW | {"code/b.py.edited": "by hand"}
    assert "b.py.edited (edited since then)" in capsys.readouterr().err


def test_links_stay_and_what_they_lead_to_is_written(tmp_path):
    for name in ("one", "two", "three"):
        (tmp_path / name).write_text("old")
        (tmp_path / f"to_{name}").symlink_to(name)

    with changing(tmp_path) as found:
        found.replace({tmp_path / "to_one": b"new"})
    write_atomically(tmp_path / "to_two", b"new")
    with whole_file(tmp_path / "to_three") as file:
        file.write(b"new")

    for name in ("one", "two", "three"):
        assert (tmp_path / f"to_{name}").is_symlink()
        assert (tmp_path / name).read_text() == "new"


def test_what_cannot_be_replaced_leaves_nothing_else(tmp_path):
    (tmp_path / "folder").mkdir()

    with pytest.raises(OSError, match="folder"):
        write_atomically(tmp_path / "folder", b"new")

    assert [path.name for path in tmp_path.iterdir()] == ["folder"]


def test_a_second_one_waits_and_then_says_who_it_is(place, monkeypatch):
    monkeypatch.setattr(files, "_PATIENCE", 0.05)

    with changing(place):
        settle(place)  # who reads need not wait for who has not begun to replace
        with (
            pytest.raises(UsageError, match=rf"\({os.getpid()}\)"),
            changing(place),
        ):
            pass

    change(place)


@pytest.mark.parametrize("text", ["", "12\n[[", '12\n["who', "garbage\n[\n", "\x00\n["])
def test_a_journal_that_was_not_written_to_its_end_is_of_no_change(place, text):
    (place / JOURNAL).write_text(text)

    settle(place)
    change(place)

    assert standing(place) == NEW


def test_a_journal_of_another_user_is_not_believed(place, monkeypatch, refused):
    (place / JOURNAL).write_text('12\n[["a.xmi", "code/b.py", null, false]]\n"whole"\n')
    monkeypatch.setattr(os, "geteuid", lambda: os.getuid() + 1)

    with refused(UsageError):
        settle(place)

    assert OLD.items() <= standing(place).items()


def test_a_new_folder_is_there_whole_or_not_at_all(tmp_path):
    for step in count():
        folder = tmp_path / "here" / "new"
        with crash_after(step), whole_folder(folder) as new:
            (new / "deep").mkdir()
            (new / "deep" / "file").write_text("whole")
        is_over = folder.exists() and not (folder.parent / JOURNAL).exists()
        settle(folder.parent)
        if not folder.exists():
            with whole_folder(folder) as new:
                (new / "deep").mkdir()
                (new / "deep" / "file").write_text("whole")

        assert standing(tmp_path / "here") == {"new/deep/file": "whole"}
        (folder / "deep" / "file").unlink()
        (folder / "deep").rmdir()
        folder.rmdir()
        if is_over:
            break
    assert step > 3
