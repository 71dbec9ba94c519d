"""What another version of the world's rules left behind is read, and refused where it would fly."""

import pytest

from mrsfi_runtime.model.fault_types import SEMANTICS
from mrsfi_runtime.record.settings import COVER
from tests.support.cli import contents, edit, execute, mrsfi, workspace
from tests.support.interrupted import MISSION

NUMBER = f'"semantics": {SEMANTICS}'


@pytest.fixture
def quick(tmp_path):
    """Folder with models/ and generated/ of the mission of 200 ticks."""
    return workspace(tmp_path, MISSION)


@pytest.mark.parametrize("words", [("replay",), ("evolve", "--resume")])
def test_a_campaign_of_later_rules_is_read_and_never_flown(campaign, tmp_path, words):
    later = NUMBER.replace(str(SEMANTICS), str(SEMANTICS + 1)).replace(" ", "")
    here = NUMBER.replace(" ", "")
    execute(campaign, f"UPDATE meta SET value = replace(value, '{here}', '{later}')")
    mrsfi("report", campaign, cwd=tmp_path)
    before = contents(campaign)

    error = mrsfi(*words, campaign, cwd=tmp_path, expected=9).stderr

    assert f"{campaign}: found semantics {SEMANTICS + 1}; expected semantics {SEMANTICS}" in error
    assert contents(campaign) == before


def test_code_generated_for_older_rules_is_refused_until_it_is_generated_anew(quick, approved):
    flight = ("simulate", MISSION)
    edit(quick / "generated" / MISSION / "manifest.json", f"{NUMBER},", "")

    error = mrsfi(*flight, cwd=quick, expected=4).stderr

    approved(error)
    mrsfi("generate", MISSION, cwd=quick)
    mrsfi(*flight, cwd=quick)


@pytest.mark.parametrize("words", [("evolve", "--resume"), ("weaknesses",)])
def test_a_search_by_other_rules_of_cover_is_neither_continued_nor_counted_again(quick, words):
    mrsfi("evolve", MISSION, "--algorithm", "cover", "--evaluations", 40, "--out", "run", cwd=quick)
    execute(quick / "run", """UPDATE meta SET value = replace(value, '"cover":2', '"cover":1')""")
    execute(quick / "run", "DELETE FROM meta WHERE key = 'weaknesses'")
    before = contents(quick / "run")

    error = mrsfi(*words, "run", cwd=quick, expected=9).stderr

    assert f"found a search by version {COVER - 1} of `cover`" in error
    assert contents(quick / "run") == before
