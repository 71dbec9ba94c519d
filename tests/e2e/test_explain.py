"""What ``mrsfi explain`` prints and writes, held to what other commands fly."""

import re
from pathlib import Path

import pytest

from tests.support.cli import MISSION, execute, mrsfi, mrsfi_json, stop_specification
from tests.tiers import night, slow

FAST = ("--engine", "reference")
COMPILED = ("--engine", "compiled")
"""For the paper's mission, which other tests have compiled."""


def by_hand(place: Path, *windows: tuple[int, int]) -> Path:
    return stop_specification(place / "models" / MISSION / "stop.xmi", windows)


def explained(*arguments, cwd):
    return mrsfi_json("explain", *arguments, cwd=cwd)["explanations"]


def flown_counts(flight, columns):
    goals = {goal["id"]: goal for goal in flight["goals"]}
    return [goals[column["goal"]][column["kind"]] for column in columns]


@slow
def test_a_cause_set_flown_again_has_the_counts_that_were_printed(campaign, place):
    (found,) = explained(campaign, cwd=place)

    cause = found["cause_set"]
    flight = mrsfi_json("simulate", MISSION, "--faults", cause["file"], cwd=place)
    assert [fault["id"] for fault in flight["faults"]] == cause["faults"]
    assert flown_counts(flight, found["columns"]) == cause["counts"]
    simple = found["simplest"]
    flight = mrsfi_json("simulate", MISSION, "--faults", simple["file"], cwd=place)
    assert flown_counts(flight, found["columns"]) == simple["counts"]
    assert [
        (fault["id"], fault["start"], fault["finish"], fault["values"])
        for fault in flight["faults"]
    ] == [
        (fault["id"], fault["start"], fault["finish"], fault["values"])
        for fault in simple["faults"]
    ]
    kept = zip(simple["counts"], cause["counts"], strict=True)
    assert all(after >= 0.99 * before for after, before in kept)
    assert {column["goal"] for column in found["columns"]} == {"g1", "g3"}
    kept = zip(cause["counts"], found["counts"], strict=True)
    assert all(after >= 0.95 * before for after, before in kept)
    assert 0 < len(cause["faults"]) < found["n_faults"] == 20
    shares = [fault["share"] for fault in found["faults"] if fault["share"]]
    for column, total in enumerate(map(sum, zip(*shares, strict=True))):
        expected = cause["counts"][column] - found["fault_free"][column]
        assert total == pytest.approx(expected, abs=1e-9)
    goals = [each for each in found["goals"] if each["faults"]]
    assert {each["goal"] for each in goals} == {"g1", "g3"}
    for each in goals:
        flight = mrsfi_json("simulate", MISSION, "--faults", each["file"], cwd=place)
        assert [fault["id"] for fault in flight["faults"]] == each["faults"]
        flown = flown_counts(flight, found["columns"])
        for column, after, before in zip(found["columns"], flown, found["counts"], strict=True):
            assert column["goal"] != each["goal"] or after >= 0.95 * before


@night
def test_what_is_explained_are_those_that_were_asked_for(campaign, place):
    both = mrsfi_json("explain", campaign, "--top", "2", cwd=place)
    best, second = both["explanations"]
    assert explained(campaign, "--best", cwd=place) == [best]
    name = Path(second["cause_set"]["file"]).stem
    index = name.removeprefix("evaluation_").removesuffix("-cause")
    assert explained(campaign, "--evaluation", index, cwd=place) == [second]
    assert Path(second["cause_set"]["file"]).parent == campaign / "causes"


@slow
def test_a_fault_that_does_it_alone_is_named(place):
    path = by_hand(place, (10, 11), (100, 900), (950, 951))

    text = mrsfi("explain", MISSION, "--faults", path, *COMPILED, cwd=place).stdout

    assert (
        "stop.xmi: the cause set has 1 of 3 faults and keeps 95 % of every goal's believed and true"
        in text
    )
    assert re.search(r"\nh2 +g\d +believed +sole ", text)
    assert "Bystanders to every goal: h1 h3\n" in text
    assert "h2 (StopRobot) forged the motion of LEN (r1) from tick 100 to 900. At tick" in text
    assert "\ncause set        " in text
    flight = mrsfi_json(
        "simulate", MISSION, "--faults", path.with_name("stop-cause.xmi"), cwd=place
    )
    assert [(fault["id"], fault["start"]) for fault in flight["faults"]] == [("h2", 100)]


@pytest.mark.parametrize(("windows", "n"), [([], "0 faults"), ([(100, 101)], "1 fault")])
def test_what_violates_nothing_has_nothing_to_explain(windows, n, place):
    path = by_hand(place, *windows)

    text = mrsfi("explain", MISSION, "--faults", path, *FAST, cwd=place).stdout

    assert text == f"{path}: {n}. No goal is violated, so there is nothing to explain\n"
    (found,) = explained(MISSION, "--faults", path, *FAST, cwd=place)
    assert not found["is_violated"]
    assert not [*path.parent.glob("*-cause.xmi")]


def test_the_measure_and_the_share_can_be_chosen(campaign, place):
    (found,) = explained(campaign, "--measure", "true", "--keep", "0.5", cwd=place)

    assert {column["kind"] for column in found["columns"]} == {"true"}
    assert found["keep"] == 0.5


def test_a_record_that_flies_otherwise_is_not_explained(campaign, place):
    execute(campaign, "UPDATE evaluation SET digest = 'forged'")

    assert "digest" in mrsfi("explain", campaign, cwd=place, expected=7).stderr
    assert not (campaign / "causes").exists()


@pytest.mark.parametrize("option", ["--best", "--top=3"])
def test_a_campaign_without_evaluations_is_answered(option, campaign, place, approved):
    execute(campaign, "DELETE FROM evaluation")

    error = mrsfi("explain", campaign, option, cwd=place, expected=9).stderr

    approved(error)


@pytest.mark.parametrize(
    ("arguments", "code"),
    [
        (("RUN", "--best", "--top", "2"), 2),
        (("RUN", "--seed", "3"), 2),
        ((MISSION,), 2),
        ((MISSION, "--faults", "FILE", "--top", "2"), 2),
        ((MISSION, "--faults", "nowhere.xmi"), 2),
        (("RUN", "--evaluation", "9999"), 9),
        (("RUN", "--keep", "0"), 2),
        ((MISSION, "--faults", "KEPT"), 2),
    ],
)
def test_wrong_use_is_answered(arguments, code, flown, place, approved):
    named = {
        "RUN": flown,
        "KEPT": f"models/{MISSION}/regressions/case_a_1.xmi",
        "FILE": by_hand(place, (1, 2)),
    }
    words = [named.get(word, word) for word in arguments]

    approved(mrsfi("explain", *words, cwd=place, expected=code).stderr)
