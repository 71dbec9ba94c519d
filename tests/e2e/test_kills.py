"""Commands that change a project, killed at any step: the next one finds all of it, or nothing."""

import subprocess
from pathlib import Path

import pytest

from tests.support.cli import MISSION, command_line, mrsfi, workspace
from tests.support.crashes import killed
from tests.support.rendezvous import NAME
from tests.tiers import night, seeds


def files(folder: Path) -> dict[str, bytes]:
    return {
        str(path.relative_to(folder)): path.read_bytes()
        for path in sorted(folder.rglob("*"))
        if path.is_file() and path.parent.name != "__pycache__"
    }


def all_or_nothing(place, work, words, then, every=1):
    """Return how often a killed command left all, and how often nothing, after the next one."""
    before, after = files(place), None
    found = []
    for attempt in killed(place, work, words, then, every):
        after = after or files(work / "done")
        assert attempt["code"] == 0, attempt
        standing = files(Path(attempt["folder"]))
        assert standing in (before, after), attempt
        assert ("finished" in attempt["told"]) <= (standing == after)
        found.append(standing == after)
    return found.count(True), found.count(False)


@pytest.mark.parametrize("every", [12, pytest.param(1, marks=night)])
def test_a_killed_rename_is_done_or_not_at_all(tmp_path, every):
    place = workspace(tmp_path / "place")
    words = ("rename", MISSION, "r1=leader", "g3=power")

    n_done, n_undone = all_or_nothing(
        place, tmp_path, words, ("generate", MISSION, "--check"), every
    )

    assert n_done * every >= 12
    assert n_undone * every >= 24


@pytest.mark.parametrize("every", [6, pytest.param(1, marks=night)])
def test_a_killed_keep_can_be_repeated(found, tmp_path, every):
    words = ("keep", "runs/it", "--weakness", "3")

    attempts = killed(found, tmp_path, words, ("validate", NAME), every)

    for attempt in attempts:
        assert attempt["code"] == 0
        kept = [*(Path(attempt["folder"]) / "models" / NAME / "regressions").glob("*")]
        assert len(kept) in (0, 2)
    folder = Path(attempts[0]["folder"])
    mrsfi(*words, cwd=folder)
    assert (
        "1 of 1 kept weaknesses is within its limit"
        in mrsfi("check", "--engine", "reference", cwd=folder).stdout
    )


@pytest.mark.parametrize("attempt", seeds(range(8), 1, 2))
def test_two_renames_at_once_follow_each_other(tmp_path, attempt):
    place = workspace(tmp_path)
    renames = ("r1=leader", ("r1=first", "r2=second")[attempt % 2])

    both = [
        subprocess.Popen(
            command_line("rename", MISSION, rename), cwd=place, stderr=subprocess.PIPE, text=True
        )
        for rename in renames
    ]
    told = [each.communicate()[1] for each in both]

    codes = sorted(each.returncode for each in both)
    if attempt % 2:
        assert codes == [0, 0], told
        assert 'ID="second"' in (place / "models" / MISSION / "mission.xmi").read_text()
    else:
        assert codes == [0, 2]
        assert "found 'r1', but no element has this ID" in "".join(told)
    mrsfi("generate", MISSION, "--check", cwd=place)
