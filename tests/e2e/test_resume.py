import shutil
import subprocess
from pathlib import Path
from random import Random
from signal import SIGKILL
from time import monotonic
from typing import Any

import pytest

from tests.support.cli import (
    command_line,
    contents,
    disturbed,
    execute,
    mrsfi,
    mrsfi_json,
    press,
    terminate,
    workspace,
)
from tests.support.interrupted import MISSION, evaluations
from tests.tiers import slow

OPTIONS = ("--population", "8", "--generations", "6", "--seed", "3", "--workers", "1")
EVOLVE = ("evolve", MISSION, *OPTIONS)


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder with models and generated code of the small mission."""
    return workspace(tmp_path_factory.mktemp("place"), MISSION)


@pytest.fixture(scope="module")
def lifetime(place: Path) -> tuple[Any, float]:
    """What a campaign in ``runs/whole`` found without interruption, and in how many seconds."""
    start = monotonic()
    found = mrsfi_json(*EVOLVE, "--out", "runs/whole", cwd=place)
    return found, monotonic() - start


@pytest.fixture(scope="module")
def whole(lifetime: tuple[Any, float]) -> Any:
    """What the campaign found, as ``--json`` prints it."""
    return lifetime[0]


@pytest.fixture
def campaign(whole: Any, place: Path, tmp_path: Path) -> Path:
    """Copy of the finished campaign."""
    del whole
    return Path(shutil.copytree(place / "runs" / "whole", tmp_path / "whole"))


@slow
def test_a_command_killed_at_any_moment_of_its_life_is_resumed_or_begun_anew(place, lifetime):
    whole, seconds = lifetime
    random = Random(11)

    for number in range(3):
        out = place / "runs" / f"killed-{number}"
        killed(random.random() * seconds, *EVOLVE, "--out", out, cwd=place)
        is_begun = (out / "campaign.sqlite").exists()
        before = evaluations(out) if is_begun else ()
        again = ("evolve", "--resume", out) if is_begun else (*EVOLVE, "--out", out)
        found = mrsfi_json(*again, cwd=place)

        names = {"folder": "", "campaign": ""}
        assert found | names == whole | names
        assert evaluations(out)[: len(before)] == before
        assert (out / "report.md").is_file()


def killed(seconds: float, *arguments: str | Path, cwd: Path) -> None:
    with subprocess.Popen(
        command_line(*arguments), cwd=cwd, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
    ) as process:
        try:
            process.wait(timeout=seconds)
        except subprocess.TimeoutExpired:
            process.send_signal(SIGKILL)


@slow
@pytest.mark.parametrize("end", [press, terminate])
def test_who_ends_it_is_told_how_to_go_on_and_the_result_is_that_of_one_run(place, whole, end):
    out = place / "runs" / f"stopped-{end.__name__}"

    # Compiled, the rest may be over before the signal.
    slow = (*EVOLVE, "--engine", "reference", "--workers", "2")
    done = disturbed(*slow, "--out", out, cwd=place, sign="generation 2/", disturb=end)
    n_before = len(evaluations(out))
    reported = mrsfi_json("report", out, cwd=place)
    mrsfi("replay", out, cwd=place)
    resumed = mrsfi("evolve", "--resume", out, "--workers", "2", cwd=place)

    assert done.returncode == 130, done.stderr
    assert f"go on with: mrsfi evolve --resume {out}" in done.stderr
    assert f"mrsfi report {out}" in done.stderr
    assert "Traceback" not in done.stderr
    assert reported["n_generations"] >= 1
    assert f" {n_before} evaluations and 0 failures are recorded" in resumed.stderr
    assert "generation 0/" not in resumed.stderr
    assert f"digest    {whole['digest']}" in resumed.stdout.splitlines()
    assert 0 < n_before < len(evaluations(out)) == whole["n_evaluations"]


@slow
def test_the_command_of_a_finished_campaign_repeated_with_resume_only_writes_the_report_anew(
    campaign, tmp_path, whole
):
    report = (campaign / "report.md").read_bytes()
    (campaign / "report.md").unlink()
    again = (*EVOLVE, "--case", "a", "--engine", "reference")

    done = mrsfi(*again, "--resume", campaign, cwd=tmp_path)

    assert "was finished already" in done.stderr
    assert f"digest    {whole['digest']}" in done.stdout.splitlines()
    assert (campaign / "report.md").read_bytes() == report


@pytest.mark.parametrize(
    "options",
    [
        ("--seed", "8"),
        ("--case", "b"),
        ("--population", "9"),
        ("--evaluations", "9"),
        ("--algorithm", "drift"),
        ("--mission-seed", "2"),
        ("uuv_sampling",),
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

    assert f"copy of {Path(name).name} is another one" in error
    lock = {"campaign.lock": None}
    assert {**contents(campaign), **lock} == {**before, **lock}


def test_a_record_that_does_not_follow_from_its_settings_ends_with_9(campaign, tmp_path):
    execute(campaign, "UPDATE evaluation SET specification = '[]' WHERE idx = 3")

    error = mrsfi("evolve", "--resume", campaign, cwd=tmp_path, expected=9).stderr

    assert "specification 3 of the search is another one" in error
