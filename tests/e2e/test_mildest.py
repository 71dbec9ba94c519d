"""The least that breaks a goal, of a campaign that evolved and was harvested, is told."""

import csv

import pytest

from tests.support.cli import mrsfi, mrsfi_json
from tests.support.rendezvous import DEADLINE

MILDEST = ("weaknesses", "runs/it", "--mildest", "--engine", "reference", "--workers", "1")


def test_there_is_one_of_each_goal_and_set_of_faults_that_holds_in_three_seeds(found):
    shown = mrsfi_json("weaknesses", "runs/it", cwd=found)

    least = mrsfi_json(*MILDEST, cwd=found)

    sets = [(one["goal"], *one["faults"]) for one in least]
    assert len(sets) == len({*sets})
    assert {*sets} == {(one["goal"], *one["faults"]) for one in shown}
    assert {one["number"] for one in least} == {one["number"] for one in shown}
    assert {(one["seeds"]["held"], one["seeds"]["of"]) for one in least} == {(3, 3)}
    assert least[0]["flights"] > 0


def test_a_robot_is_stopped_just_as_long_as_it_takes_to_be_late(found):
    slack = DEADLINE - 50  # ticks that a robot may lose

    (stopped,) = (
        one
        for one in mrsfi_json(*MILDEST, "--goal", "g2", cwd=found)
        if one["faults"] == ["stop_b"]
    )

    (timed,) = stopped["witness"]
    assert slack <= timed["finish"] - timed["start"] + 1 <= slack + 4
    assert stopped["sentence"].startswith("g2 fails when stop_b is active for ")


def test_sentences_and_flights_are_printed_and_seeds_if_asked_for(found):
    least = mrsfi_json(*MILDEST, cwd=found)

    said = " ".join(mrsfi(*MILDEST, "--seeds", "5", cwd=found).stdout.split())

    for one in least:
        assert f"{one['number']} {one['sentence']} ({one['flights']} flight" in said
    assert "5/5" in said


def test_failure_modes_are_of_mildest_forms_where_these_are_known(found, tmp_path):
    kept, sought = tmp_path / "kept.csv", tmp_path / "sought.csv"

    mrsfi(*MILDEST[:2], "--fmea", kept, *MILDEST[3:], cwd=found)
    least = mrsfi_json(*MILDEST, "--fmea", sought, cwd=found)

    known, every = (
        {int(row["weakness"]): row for row in csv.DictReader(path.read_text("utf-8").splitlines())}
        for path in (kept, sought)
    )
    mildest = {n for n, row in known.items() if row["mildest variant"]}
    assert len(mildest) == len({one["goal"] for one in least}) < len(least)
    sentences = dict.fromkeys(["mildest variant"])  # count the trials, which are more
    assert {n: known[n] | sentences for n in mildest} == {n: every[n] | sentences for n in mildest}
    assert {n: row["mildest variant"] for n, row in every.items()} == {
        one["number"]: one["sentence"] for one in least
    }
    for one in least:
        for timed in one["witness"]:
            window = f"from tick {timed['start']} to {timed['finish']}"
            assert window in every[one["number"]]["failure mode"]


def test_values_and_windows_that_break_a_goal_are_written_as_a_table_or_drawn(found, tmp_path):
    (stopped,) = (
        one
        for one in mrsfi_json("weaknesses", "runs/it", "--goal", "g2", cwd=found)
        if (one["faults"], one["measure"]) == (["stop_b"], "true")
    )
    number, table, picture = str(stopped["number"]), tmp_path / "map.csv", tmp_path / "map.png"

    mrsfi(*MILDEST[:2], "--map", number, str(table), *MILDEST[3:], cwd=found)
    mrsfi(*MILDEST[:2], "--map", number, str(picture), *MILDEST[3:], cwd=found)

    header, *rows = (line.split(",") for line in table.read_text("utf-8").splitlines())
    assert header == ["off", "ticks", "is_broken"]
    slack = DEADLINE - 50
    assert all(is_broken == str(int(ticks) > slack) for _, ticks, is_broken in rows)
    assert picture.read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize(
    "words",
    [("99", "map.csv"), ("1", "map.pdf")],
)
def test_a_map_of_what_there_is_not_is_refused(found, tmp_path, words, approved):
    number, name = words

    refused = mrsfi(*MILDEST[:2], "--map", number, str(tmp_path / name), cwd=found, expected=2)

    approved(refused.stderr)
    assert not [*tmp_path.iterdir()]
