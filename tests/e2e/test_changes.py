"""Campaigns of a mission, before and after an edit: what went, what came, what stayed."""

import re
from pathlib import Path

import pytest

from mrsfi.campaign_folders import open_campaign
from mrsfi.explaining import harvested, known_since
from tests.support.cli import edit, execute, mrsfi, mrsfi_json
from tests.support.rendezvous import NAME

COVER = ("--case", "cover.toml", "--algorithm", "cover", "--evaluations", "60")
FAST = ("--engine", "reference", "--workers", "1")
CLOSE = 'tolerance="3.0"'


@pytest.fixture
def before_and_after(small):
    """Folder with a campaign, and one of the mission in which g1 accepts any place."""
    (small / "cover.toml").write_text("[search]\n", encoding="utf-8")
    mrsfi("evolve", NAME, *COVER, *FAST, "--out", "runs/before", cwd=small)
    mission = small / "models" / NAME / "mission.xmi"
    mission.write_text(mission.read_text().replace(CLOSE, 'tolerance="3000.0"', 1))
    mrsfi("generate", NAME, cwd=small)
    mrsfi("evolve", NAME, *COVER, *FAST, "--out", "runs/after", cwd=small)
    return small


def told(found):
    return {(each["goal"], *each["faults"]): each["verdict"] for each in found}


def test_what_an_edit_mends_went_what_it_breaks_came_and_the_rest_stayed(before_and_after):
    files = ("--markdown", "change.md", "--html", "change.html")
    there = mrsfi_json("compare", "runs/before", "runs/after", *FAST, cwd=before_and_after)
    back = mrsfi_json("compare", "runs/after", "runs/before", *FAST, cwd=before_and_after)
    done = mrsfi("compare", "runs/before", "runs/after", *FAST, *files, cwd=before_and_after)

    gone = {("g1", "lie_a"), ("g1", "stop_a")}
    assert {way for way, verdict in told(there).items() if verdict == "went"} == gone
    assert {way for way, verdict in told(back).items() if verdict == "came"} == gone
    assert {*told(there).values()} == {"went", "stayed"}
    assert all("–" not in each["marks"] for each in there if each["verdict"] == "stayed")
    assert "Weaknesses: 2 went, none came, 4 stayed." in done.stdout
    text = (before_and_after / "change.md").read_text(encoding="utf-8")
    assert text.startswith("Weaknesses: 2 went, none came, 4 stayed.")
    assert re.search(
        r"\n\| went \| stop_a \| ● – \| .* \| g1: a is stopped for 120 ticks \|\n", text
    )
    assert "2 went, none came" in (before_and_after / "change.html").read_text(encoding="utf-8")


def test_a_weakness_whose_fault_is_gone_from_the_pool_cannot_be_flown(before_and_after):
    faults = before_and_after / "models" / NAME / "faults.xmi"
    edit(faults, 'ID="stop_b"', 'ID="halt_b"')
    mrsfi("generate", NAME, cwd=before_and_after)
    mrsfi("evolve", NAME, *COVER, *FAST, "--out", "runs/other", cwd=before_and_after)

    found = mrsfi_json("compare", "runs/before", "runs/other", *FAST, cwd=before_and_after)

    unknown = [each for each in found if each["verdict"] == "cannot be flown"]
    assert {(each["goal"], *each["faults"]) for each in unknown} >= {("g2", "stop_b")}
    assert all("stop_b" in each["remark"] or "halt_b" in each["remark"] for each in unknown)


def test_a_history_has_each_campaign_with_date_and_commit_and_the_course_of_each_weakness(
    before_and_after, approved
):
    few = ("--case", "cover.toml", "--algorithm", "cover", "--evaluations", "5", *FAST)
    mrsfi("evolve", NAME, *few, "--seed", "2", "--out", "runs/few", cwd=before_and_after)
    mrsfi(
        "decide",
        "runs/before",
        "1",
        "accept",
        "--because",
        "=1+1",
        "--by",
        "Li",
        cwd=before_and_after,
    )
    database = before_and_after / "runs" / "broken" / "campaign.sqlite"
    database.parent.mkdir()
    database.write_text("no database")
    mrsfi("evolve", NAME, *few, "--no-explain", "--out", "runs/half", cwd=before_and_after)
    files = ("--html", "history.html", "--output", "history.svg")

    done = mrsfi("history", *FAST, *files, cwd=before_and_after)

    broken, half = (line for line in done.stderr.splitlines() if line.startswith("left out"))
    assert broken.startswith("left out   runs/broken")
    assert half == "left out   runs/half: has no finished search for weaknesses"
    approved(re.sub(r"\d{4}-\d\d-\d\d", "2026-11-28", done.stdout))
    assert (before_and_after / "history.svg").is_file()
    page = (before_and_after / "history.html").read_text(encoding="utf-8")
    assert "g1: stop_a" in page


def test_a_campaign_of_an_earlier_mrsfi_is_without_date_the_earliest_and_is_not_flown(
    before_and_after,
):
    old = "json_set(json_remove(value, '$.created'), '$.semantics', 1)"
    execute(
        before_and_after / "runs" / "after", f"UPDATE meta SET value = {old} WHERE key = 'manifest'"
    )

    words = mrsfi("history", "--all", *FAST, cwd=before_and_after).stdout

    assert re.search(r"\n1 +after +not recorded +not recorded ", words)
    assert re.search(r"\ncannot be flown +stop_a +\? ● +2\d{3}.* g1: ", words)
    assert "found semantics 1" in words
    assert "In all campaigns: none." in words


def test_the_first_campaign_that_found_a_weakness_is_known_without_flights(
    before_and_after, monkeypatch
):
    monkeypatch.chdir(before_and_after)
    for name, day in (("before", "2026-11-27"), ("after", "2026-11-28")):
        value = f"json_set(value, '$.created', '{day}')"
        execute(Path("runs") / name, f"UPDATE meta SET value = {value} WHERE key = 'manifest'")
    (before_and_after / "runs" / "broken").mkdir()
    (before_and_after / "runs" / "broken" / "campaign.sqlite").touch()

    with open_campaign(Path("runs/after")) as campaign:
        since, found = known_since(campaign), harvested(campaign).goal_weaknesses
        days = {since(each) for each in found}
        assert days == {"2026-11-27"}
        Path("runs/before").rename("before")
        alone = known_since(campaign)
        assert {alone(each) for each in found} == {"2026-11-28"}


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ((), "found no campaign with weaknesses in runs/"),
        (("runs/none",), "runs/none"),
        (("--output", "history.txt"), "found the ending '.txt'"),
    ],
)
def test_a_history_of_nothing_or_in_an_unknown_format_is_refused(words, message, small):
    code = 9 if words == ("runs/none",) else 2

    assert message in mrsfi("history", *words, cwd=small, expected=code).stderr


@pytest.mark.parametrize(
    ("words", "code"),
    [
        (("runs/before", "runs/before", "--seeds", "3"), 2),
        (("runs/before", "runs/before", "runs/before"), 2),
        (("runs/before", "runs/none"), 9),
        ((NAME, "--markdown", "x.md"), 2),
    ],
)
def test_what_makes_no_sense_beside_two_campaigns_is_refused(words, code, small, approved):
    (small / "cover.toml").write_text("[search]\n", encoding="utf-8")
    mrsfi("evolve", NAME, *COVER, *FAST, "--out", "runs/before", cwd=small)

    approved(mrsfi("compare", *words, cwd=small, expected=code).stderr)
