from pathlib import Path

import pytest

from tests.support.cli import MISSION, SMALL, contents, mrsfi

EVOLVE = ("evolve", MISSION, "--case", "b", *SMALL)


def test_the_command_of_a_finished_campaign_repeated_with_resume_only_writes_the_report_anew(
    campaign, tmp_path
):
    def reported():
        text = (campaign / "report.md").read_text()
        return [line for line in text.splitlines()[1:] if line and not line.startswith("![")]

    report = reported()
    (campaign / "report.md").unlink()

    done = mrsfi(*EVOLVE, "--engine", "reference", "--resume", campaign, cwd=tmp_path)

    assert "was finished already" in done.stderr
    assert reported() == report


@pytest.mark.parametrize(
    "options",
    [
        ("--seed", "8"),
        ("--case", "a"),
        ("--population", "9"),
        ("--evaluations", "9"),
        ("--algorithm", "drift"),
        ("--mission-seed", "2"),
        ("tight_margins",),
        ("--out", "elsewhere"),
        ("--generated", "here"),
    ],
)
def test_an_option_that_contradicts_the_campaign_ends_with_2_and_is_named(
    campaign, tmp_path, options, approved
):
    before = contents(campaign)

    error = mrsfi("evolve", "--resume", campaign, *options, cwd=tmp_path, expected=2).stderr

    approved(error)
    assert contents(campaign) == before


@pytest.mark.parametrize("name", ["generated/simulation.py", "model/mission.xmi"])
def test_a_changed_copy_of_models_or_code_ends_with_9_and_is_named(campaign, tmp_path, name):
    with (campaign / name).open("a", encoding="utf-8") as file:
        file.write("\n")
    before = contents(campaign)

    error = mrsfi("evolve", "--resume", campaign, cwd=tmp_path, expected=9).stderr

    assert f"copy of {Path(name).name} has changed" in error
    lock = {"campaign.lock": None}
    assert {**contents(campaign), **lock} == {**before, **lock}


def test_a_start_that_was_killed_is_begun_anew_in_its_folder(place):
    path = place / "runs" / "half"
    (path / "model").mkdir(parents=True)
    for name in ("campaign.sqlite.new", "campaign.lock", "model/mission.xmi"):
        (path / name).touch()

    error = mrsfi("evolve", "--resume", path, cwd=place, expected=9).stderr
    mrsfi(*EVOLVE, "--engine", "reference", "--no-explain", "--out", path, cwd=place)

    assert "interrupted before it began" in error
    assert (path / "report.md").is_file()
