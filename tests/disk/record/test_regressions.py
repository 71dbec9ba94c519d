"""What is kept beside models: which files are read, and which are refused."""

import os

import pytest

from mrsfi_runtime.errors import UsageError
from mrsfi_runtime.record.settings import Regression, kept

SOUND = {
    "found": '"here"',
    "accepted": '"known"',
    "side": '"ci"',
    "violations": '"true"',
    "mission_seeds": "[1, 2]",
    "goals": "1",
    "max": "{g1 = 3}",
}


def written(path, **changed):
    lines = (f"{key} = {value}\n" for key, value in {**SOUND, **changed}.items() if value)
    path.write_text("".join(lines), encoding="utf-8")
    return path


def test_nothing_is_kept_where_there_is_no_folder_or_none_in_it(tmp_path):
    assert kept(tmp_path) == ()
    (tmp_path / "regressions").mkdir()
    (tmp_path / "regressions" / "notes.txt").write_text("not kept", encoding="utf-8")
    assert kept(tmp_path) == ()


def test_what_is_kept_is_read_by_name(tmp_path):
    folder = tmp_path / "regressions"
    folder.mkdir()
    for name in ("b", "a"):
        (folder / f"{name}.xmi").write_text("<faults/>", encoding="utf-8")
        written(folder / f"{name}.toml")

    found = kept(tmp_path)

    sound = [
        Regression(folder / f"{n}.toml", "here", "true", (1, 2), {"g1": 3}, None, "known", "ci")
        for n in "ab"
    ]
    assert found == tuple(sound)


def test_a_file_that_cannot_be_read_is_a_defect_of_its_own(tmp_path, approved):
    folder = tmp_path / "regressions"
    folder.mkdir()
    os.mkfifo(folder / "pipe.toml")
    (folder / "folder.xmi").mkdir()
    (folder / "lonely.xmi").write_text("<faults/>", encoding="utf-8")
    written(folder / "sound.toml")

    said = {each.name: str(each.defect) for each in kept(tmp_path)}

    approved(said["pipe"])
    approved(said["folder"])
    approved(said["lonely"])
    assert said["sound"] == "None"


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("found", "3"),
        ("found", ""),
        ("accepted", "3"),
        ("violations", '"seen"'),
        ("mission_seeds", "[]"),
        ("mission_seeds", "[-1]"),
        ("mission_seeds", "[true]"),
        ("goals", "-1"),
        ("goals", ""),
        ("goals", "2"),
        ("max", "{}"),
        ("max", "{g1 = 0.5}"),
        ("more", "1"),
    ],
)
def test_limits_that_make_no_sense_are_refused(key, value, tmp_path, refused):
    path = written(tmp_path / "a.toml", **{key: value})

    with refused(UsageError):
        Regression.load(path)
