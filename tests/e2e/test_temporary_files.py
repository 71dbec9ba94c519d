"""What commands say whose flights are too long for memory, where TMPDIR cannot take them."""

import gc
import resource
import shutil
import tempfile
from contextlib import contextmanager

import pytest

from mrsfi_runtime.engine import recording
from tests.support.cli import MISSION, mrsfi

FILE = 50_000
"""Bytes of the largest file that a full disk takes."""


@pytest.fixture
def spilling(monkeypatch):
    """Have recordings of some ticks go to a file, as those of long flights do."""
    monkeypatch.setattr(recording, "CHUNK", 1 << 14)
    monkeypatch.setattr(recording, "_IN_MEMORY", 1000)


@contextmanager
def full():
    """Have no file grow any further, as on a full disk."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (FILE, before[1]))
    try:
        yield
        gc.collect()  # what is still to be written is lost in silence
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


@contextmanager
def missing():
    """Have the folder for temporary files go while the process runs."""
    with pytest.MonkeyPatch.context() as patch:
        with tempfile.TemporaryDirectory() as folder:
            patch.setattr(tempfile, "tempdir", folder)
        yield


TROUBLES = [(full, "File too large"), (missing, "No such file or directory")]


def told(reason):
    return (
        f"mrsfi: {tempfile.tempdir}: mrsfi cannot write temporary files there: {reason}; "
        "set TMPDIR to a folder with more room\n"
    )


@pytest.mark.usefixtures("spilling")
@pytest.mark.parametrize(("trouble", "reason"), TROUBLES)
@pytest.mark.parametrize(
    "words",
    [
        ("--engine", "reference", "--html", "flight.html"),
        ("--engine", "reference", "--gif", "flight.gif"),
        ("--engine", "compiled", "--log", "flight.log"),
    ],
    ids=lambda words: words[2],
)
def test_a_flight_that_cannot_be_recorded_names_the_folder(place, words, trouble, reason):
    mrsfi("simulate", MISSION, *words[:2], cwd=place)  # what is compiled is kept

    with trouble():
        done = mrsfi("simulate", MISSION, *words, cwd=place, expected=2)
        expected = told(reason)

    assert done.stderr.endswith(expected)
    assert not (place / "flight.html").exists()


@pytest.mark.usefixtures("spilling")
@pytest.mark.parametrize(
    "words", [("replay", "it", "--html", "flight.html"), ("report", "it"), ("show", "it")]
)
def test_so_does_one_of_a_campaign(ended, tmp_path, words):
    shutil.copytree(ended[0], tmp_path / "it")

    with missing():
        done = mrsfi(*words, cwd=tmp_path, expected=2)
        expected = told("No such file or directory")

    assert done.stderr.endswith(expected)


def test_an_animation_that_cannot_be_put_together_names_the_folder(place):
    with missing():
        done = mrsfi("simulate", MISSION, "--gif", "flight.gif", cwd=place, expected=2)
        expected = told("No such file or directory")

    assert done.stderr.endswith(expected)


@pytest.mark.parametrize("option", ["--log", "--trace", "--mcap"])
def test_an_output_that_cannot_be_written_is_not_blamed_on_the_mission(place, option):
    with full():
        done = mrsfi("simulate", MISSION, option, "flight", cwd=place, expected=2)

    expected = "mrsfi: flight: cannot be written: File too large; name another file\n"
    assert done.stderr.endswith(expected)
