"""What ``mrsfi show`` draws and says of weaknesses, which ``mrsfi evolve`` leaves undrawn."""

import json
import os
import shutil

import pytest

import mrsfi as api
from tests.support.cli import mrsfi, mrsfi_process
from tests.support.drawing import table, texts


@pytest.fixture
def run(ended, tmp_path):
    """Copy of a campaign that looked for weaknesses."""
    return shutil.copytree(ended[0], tmp_path / "it")


def told_of(run):
    """Return what is the least that breaks each goal, by its number, as the report has it."""
    found = json.loads((run / "summary.json").read_text(encoding="utf-8"))["weaknesses"]["found"]
    return {each["number"]: each for each in found if each["sentences"]}


def drawn(run):
    return {path.name: path.stat().st_mtime_ns for path in (run / "figures").glob("weakness_*")}


def names(*numbers):
    whats = [f"{what}.{kind}" for what in ("timeline", "map") for kind in ("png", "svg")]
    return {f"weakness_{number:02d}_{what}" for number in numbers for what in whats}


def test_the_least_that_breaks_each_goal_is_told_and_drawn_with_its_numbers(run):
    told = told_of(run)
    assert drawn(run) == {}

    shown = mrsfi("show", "it", cwd=run.parent).stdout

    assert [each["goal"] for each in told.values()] == ["g1", "g2", "g3"]
    assert drawn(run).keys() == names(*told)
    for number, each in told.items():
        assert f"\n{number}  " in shown
        assert all(f"    {sentence}\n" in shown for sentence in each["sentences"])
        assert each["mildest"]["sentence"] in shown
        for what in ("timeline", "map"):
            assert f"    it/figures/weakness_{number:02d}_{what}.png\n" in shown
        header, *rows = table(run, f"weakness_{number:02d}_timeline")
        windows = [dict(zip(header, row, strict=True)) for row in rows]
        assert [row["name"] for row in windows if row["kind"] == "fault"] == each["faults"]
        assert any(row["name"] == each["goal"] for row in windows if row["kind"] != "fault")


def test_one_is_drawn_as_it_was_flown_by_command_and_by_script(run):
    number, each = next(iter(told_of(run).items()))

    printed = mrsfi_process("show", "it", str(number), cwd=run.parent, draws=True).stdout
    (shown,) = api.Campaign(run).show(number)

    assert drawn(run).keys() == names(number)
    assert shown.title in texts(run / "figures" / f"weakness_{number:02d}_map.svg")
    assert all(path.read_bytes().startswith(b"\x89PNG") for path in shown.figures)
    assert f"\n{number}  {shown.title}\n" in f"\n{printed}"
    assert all(f"    {sentence}\n" in printed for sentence in shown.sentences)
    assert shown.sentences[1:] == tuple(each["sentences"])


def test_what_is_drawn_is_drawn_again_only_if_missing_or_older_than_the_record(run):
    mrsfi("show", "it", "1", cwd=run.parent)
    first = drawn(run)
    mrsfi("show", "it", "1", cwd=run.parent)
    kept = drawn(run)
    (run / "figures" / "weakness_01_map.svg").unlink()
    mrsfi("show", "it", "1", cwd=run.parent)
    mended = drawn(run)
    os.utime(run / "campaign.sqlite")
    mrsfi("show", "it", "1", cwd=run.parent)

    renewed = drawn(run)
    mrsfi("report", "it", cwd=run.parent)

    assert first == kept
    assert first.keys() == mended.keys() == renewed.keys()
    assert min(mended.values()) > max(first.values())
    assert min(renewed.values()) > max(mended.values())
    assert drawn(run) == {}


def test_what_cannot_be_shown_is_refused_with_the_reason(run):
    wrong = mrsfi("show", "it", "99", cwd=run.parent, expected=2)
    for code in (run / "generated").glob("*.py"):
        code.write_text("raise RuntimeError\n", encoding="utf-8")
    edited = mrsfi("show", "it", "1", cwd=run.parent, expected=9)

    assert "it: found no weakness 99; expected one of 1, 2, 3" in wrong.stderr
    assert "has changed since the campaign began" in edited.stderr
    assert wrong.stdout == edited.stdout == ""
    assert drawn(run) == {}
