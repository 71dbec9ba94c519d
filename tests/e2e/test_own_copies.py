"""A campaign flies its own copies of what its code imports, whatever the project has by now."""

import shutil
import sys
from collections.abc import Iterator
from contextlib import chdir
from pathlib import Path

import pytest

from mrsfi.campaign_folders import mission_of, open_campaign
from mrsfi_runtime.errors import UsageError
from mrsfi_runtime.record.settings import CampaignSettings
from tests.support.cli import edit, execute, mrsfi
from tests.support.edited import COLLECTIVE, write_body
from tests.support.interrupted import begin, digest
from tests.support.rendezvous import NAME, write_rendezvous

TEAM = "def late(tick):\n    return tick > 60\n"
SEARCH = """import team


def worst(findings):
    return float(team.late(99)) + sum(findings.violations)
"""
CASE = """[search]
algorithm = "random"
evaluations = 7
population = 2
faults = 2
fitness = "own:worst"
"""
CASED = ("evolve", NAME, "--case", "own.toml", "--engine", "reference")
EVOLVE = (*CASED, "--no-explain", "--workers", "1")


def forget() -> None:
    """Forget the modules of the project, as a new process would."""
    for name in ("team", "own"):
        sys.modules.pop(name, None)


@pytest.fixture(scope="module")
def searched(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Project with a finished campaign in runs/it; only to be read."""
    place = tmp_path_factory.mktemp("searched")
    collective = write_rendezvous(place) / COLLECTIVE
    write_body(collective, "imports", "import team\n")
    write_body(collective, "g1.check", "    return team.late(ci.mission.tick)\n")
    for name, text in {"team.py": TEAM, "own.py": SEARCH, "own.toml": CASE}.items():
        (place / name).write_text(text, encoding="utf-8")
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(place)
        mrsfi(*EVOLVE, "--out", "runs/it", cwd=place)
        forget()
    return place


@pytest.fixture
def place(searched: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """Copy of it whose campaign was killed in its middle, and whose modules were edited since."""
    shutil.copytree(searched, tmp_path, dirs_exist_ok=True)
    monkeypatch.syspath_prepend(tmp_path)
    execute(
        tmp_path / "runs" / "it",
        "DELETE FROM evaluation WHERE idx >= 3",
        "DELETE FROM generation WHERE idx >= 1",
        "DELETE FROM flight",
    )
    edit(tmp_path / "team.py", "> 60", "> 30")
    edit(tmp_path / "own.py", "float(", "2.0 * float(")
    yield tmp_path
    forget()


def test_a_killed_campaign_goes_on_with_its_own_copies_of_what_its_code_imports(place, searched):
    resumed = mrsfi("evolve", "--resume", "runs/it", "--no-explain", cwd=place)
    forget()
    replayed = mrsfi("replay", "runs/it", "--all", cwd=place)

    assert digest(place / "runs" / "it") == digest(searched / "runs" / "it")
    assert "same: all 7 evaluations" in replayed.stdout
    for done in (resumed, replayed):
        assert "today's project has other versions of: own.py, team.py" in done.stderr


def test_a_campaign_whose_project_lost_its_modules_can_still_be_explained(place):
    for name in ("team.py", "own.py"):
        (place / name).unlink()

    done = mrsfi("explain", "runs/it", "--evaluation", "1", "--workers", "2", cwd=place)

    assert "own copies" not in done.stderr


WORDS = (("evolve", "--resume"), ("replay",), ("explain",))


@pytest.mark.parametrize("words", WORDS)
def test_an_edited_copy_is_refused_and_named(place, words, approved):
    edit(place / "runs" / "it" / "generated" / "imported" / "team.py", "> 60", "> 61")

    error = mrsfi(*words, "runs/it", cwd=place, expected=9).stderr

    approved(error)


@pytest.mark.parametrize("name", ["own.py", "more.py"])
def test_a_lost_copy_and_one_too_many_are_refused(place, name, approved):
    copy = place / "runs" / "it" / "generated" / "imported" / name
    copy.unlink() if copy.exists() else copy.touch()

    approved(mrsfi("replay", "runs/it", cwd=place, expected=9).stderr)


@pytest.mark.parametrize("models", ["some/models", "some"])
def test_a_mission_given_by_path_is_found_where_it_lies(place, models, refused):
    there = place / models
    shutil.copytree(place / "models", there, dirs_exist_ok=True)
    shutil.copytree(place / "generated", place / "some" / "generated")
    (place / "mrsfi.toml").touch()
    with chdir(place / "some"):
        begin(place / "there", there / NAME, CampaignSettings())

    with chdir(place / "runs"), open_campaign(place / "there") as campaign:
        found = mission_of(campaign)
        named = found.named
        shutil.rmtree(there / NAME)
        with refused(UsageError):
            mission_of(campaign)

    assert (place / "runs" / found.models).resolve() == there / NAME
    assert named == f"../{models}/{NAME}"


def test_a_weakness_is_kept_where_its_mission_lies(found, tmp_path):
    place = Path(shutil.copytree(found, tmp_path / "place"))
    shutil.copytree(place / "models", place / "some")
    moved = f"UPDATE meta SET value = json_set(value, '$.place', 'some/{NAME}')"
    execute(place / "runs" / "it", f"{moved} WHERE key = 'manifest'")

    mrsfi("keep", "runs/it", "--weakness", "1", cwd=place)
    again = mrsfi("keep", "runs/it", "--weakness", "1", cwd=place, expected=2).stderr

    kept = {path.relative_to(place).as_posix() for path in place.rglob("*weakness-1.*")}
    assert kept == {f"some/{NAME}/regressions/it-weakness-1.{kind}" for kind in ("toml", "xmi")}
    assert f"mrsfi keep some/{NAME} --update" in again


def test_another_mission_of_the_same_folder_name_is_refused(found, tmp_path, approved):
    place = Path(shutil.copytree(found, tmp_path / "place"))
    edit(place / "models" / NAME / "mission.xmi", 'name="rendezvous"', 'name="parade"')

    error = mrsfi("keep", "runs/it", "--weakness", "1", cwd=place, expected=2).stderr

    approved(error)
