import os
import shutil
import subprocess
import sys
from pathlib import Path
from random import Random
from signal import SIGKILL, SIGSTOP
from time import monotonic, sleep

import pytest

from m2t.generate import generate
from mrsfi_runtime.errors import RecordError
from mrsfi_runtime.generated_code import load_code
from mrsfi_runtime.record.folder import CampaignFolder, only_writer
from mrsfi_runtime.record.settings import CampaignSettings
from mrsfi_runtime.record.store import CampaignStore
from tests.support.cli import edit, mrsfi, workspace
from tests.support.interrupted import (
    MISSION,
    SEARCH,
    WRITE,
    are_gone,
    begin,
    digest,
    evaluations,
    finished,
    killed_after,
    running,
)
from tests.support.processes import children
from tests.support.triggers import drawn_triggers, in_xmi
from tests.tiers import night, slow

SETTINGS = CampaignSettings(population=8, generations=8, seed=3)
LONG = CampaignSettings(population=8, generations=1000, seed=3)
"""For what is not to come to its end by itself."""

MANY = CampaignSettings(population=20, generations=15, seed=3)
"""For evaluations that take no time."""


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder with models and generated code of the small mission."""
    return workspace(tmp_path_factory.mktemp("place"), MISSION)


@pytest.fixture(scope="module")
def whole(place: Path) -> Path:
    """Folder of a campaign that was never interrupted."""
    path = begin(place / "whole", place / "models" / MISSION, SETTINGS)
    finished(SEARCH, path, 1)
    return path


@slow
@pytest.mark.parametrize(("n_workers", "n_kills"), [(2, 3), pytest.param(1, 20, marks=night)])
def test_a_campaign_killed_again_and_again_ends_as_one_that_never_was(
    place, whole, n_workers, n_kills
):
    path = begin(place / f"killed-{n_workers}", place / "models" / MISSION, SETTINGS)
    random = Random(n_workers)
    most = 2 * len(evaluations(whole)) // n_kills  # per run, so that the last kills come late
    before = evaluations(path)
    n_killed = 0

    for _ in range(n_kills):
        n_evaluated, moment = random.randint(0, most), 0.02 * random.random()
        n_killed += killed_after(moment, SEARCH, path, n_workers, n_evaluated=n_evaluated)
        found = evaluations(path)
        assert found[: len(before)] == before
        before = found
    n_evaluated = finished(SEARCH, path, n_workers)

    assert n_killed > n_kills / 2
    assert n_evaluated + len(before) == len(evaluations(whole))
    assert evaluations(path) == evaluations(whole)
    assert digest(path) == digest(whole)
    with CampaignStore.open(path) as store, CampaignStore.open(whole) as other:
        assert [*store.generations()] == [*other.generations()]


def test_a_killed_campaign_of_a_pool_with_triggers_ends_as_one_that_never_was(tmp_path):
    place = workspace(tmp_path, MISSION)
    models, generated = place / "models" / MISSION, place / "generated" / MISSION
    code = load_code(generated)
    declared = in_xmi(drawn_triggers(Random(1), code.mission, code.pool))
    edit(models / "faults.xmi", "</faults:F", f"{declared}</faults:F")
    generate(models, generated)
    settings = CampaignSettings(algorithm="guided", population=6, generations=4, seed=3)
    campaigns = [begin(place / name, models, settings) for name in ("never", "killed")]

    finished(SEARCH, campaigns[0], 1)
    assert killed_after(0.0, SEARCH, campaigns[1], 1, n_evaluated=9)
    n_left = finished(SEARCH, campaigns[1], 1)

    known, again = map(evaluations, campaigns)
    assert known == again
    assert 0 < n_left < len(known)
    assert digest(campaigns[0]) == digest(campaigns[1])
    assert any(
        timed.trigger and n_applied
        for each in known
        for timed, n_applied in zip(each.specification, each.outcome.applied, strict=True)
    )


@night
def test_kills_inside_a_write_leave_nothing_to_repair(place):
    undisturbed = begin(place / "written", place / "models" / MISSION, MANY)
    n_all = finished(WRITE, undisturbed)
    path = begin(place / "torn", place / "models" / MISSION, MANY)
    random = Random(5)
    before = evaluations(path)
    n_torn = 0

    for _ in range(15):
        killed_after(0.04 * random.random(), WRITE, path)
        n_torn += (path / "campaign.sqlite-journal").exists()
        found = evaluations(path)
        assert found[: len(before)] == before
        before = found
    n_evaluated = finished(WRITE, path)

    assert n_torn > 0
    assert n_evaluated + len(before) == n_all
    assert evaluations(path) == evaluations(undisturbed)
    assert digest(path) == digest(undisturbed)


def test_workers_end_with_their_killed_campaign(place):
    path = begin(place / "orphans", place / "models" / MISSION, LONG)

    with running(SEARCH, path, 2) as process:
        workers = started_workers(process)
        process.kill()

        assert len(workers) == 2
        assert are_gone(workers, within=20)


def started_workers(process: subprocess.Popen[str]) -> list[int]:
    limit = monotonic() + 20
    while len(found := children(process.pid, b"spawn_main")) < 2 and monotonic() < limit:
        sleep(0.01)
    return found


@slow
def test_a_killed_worker_ends_the_run_and_the_campaign_goes_on(place, whole):
    path = begin(place / "worker", place / "models" / MISSION, SETTINGS)

    with running(SEARCH, path, 2) as process:
        first, _ = started_workers(process)
        os.kill(first, SIGKILL)
        assert process.wait(timeout=60) == 1
        assert process.stderr is not None
        assert "a worker process died; resume the campaign" in process.stderr.read()
    n_before = len(evaluations(path))
    n_evaluated = finished(SEARCH, path, 2)

    assert n_before + n_evaluated == len(evaluations(whole))
    assert digest(path) == digest(whole)


def test_a_second_process_is_refused_until_the_first_is_dead(place):
    path = begin(place / "locked", place / "models" / MISSION, LONG)

    with running(SEARCH, path, 1) as process:
        process.send_signal(SIGSTOP)  # it holds its lock while it sleeps
        with pytest.raises(RecordError, match=rf"another process \({process.pid}\) running this"):
            enter(path)
        error = mrsfi("evolve", "--resume", path, cwd=place, expected=9).stderr
        assert f"another process ({process.pid})" in error
        process.kill()
        process.wait()

    enter(path)


def enter(path: Path) -> None:
    with only_writer(CampaignFolder(path)):
        pass


LIMITED = """
import resource, sys
resource.setrlimit(resource.RLIMIT_FSIZE, (150_000, 150_000))
from mrsfi_runtime.cli.main import main
sys.exit(main(sys.argv[1:]))
"""


@slow
def test_a_disk_without_room_ends_with_9_and_the_campaign_goes_on(place, whole):
    path = begin(place / "full", place / "models" / MISSION, SETTINGS)
    resume = ("evolve", "--resume", str(path), "--workers", "1")

    done = subprocess.run(
        [sys.executable, "-c", LIMITED, *resume],
        check=False,
        capture_output=True,
        encoding="utf-8",
        timeout=120,
    )
    before = evaluations(path)
    n_evaluated = finished(SEARCH, path, 1)

    assert done.returncode == 9, done.stderr
    assert f"free some room, then continue with: mrsfi evolve --resume {path}" in done.stderr
    assert "Traceback" not in done.stderr
    assert 0 < len(before) < len(evaluations(whole))
    assert n_evaluated + len(before) == len(evaluations(whole))
    assert digest(path) == digest(whole)


def test_a_start_that_was_killed_is_begun_anew_in_its_folder(place):
    path = begin(place / "half", place / "models" / MISSION, SETTINGS)
    (path / "campaign.sqlite").rename(path / "campaign.sqlite.new")
    (path / "generated" / "simulation.py").unlink()

    error = mrsfi("evolve", "--resume", path, cwd=place, expected=9).stderr
    begin(place / "half", place / "models" / MISSION, SETTINGS)

    assert "ended before it began" in error
    assert evaluations(path) == ()
    assert sorted(entry.name for entry in path.iterdir()) == [
        "campaign.lock",
        "campaign.sqlite",
        "generated",
        "model",
    ]
    assert (path / "generated" / "simulation.py").is_file()


def test_a_campaign_that_was_moved_goes_on(place, whole, tmp_path):
    path = begin(place / "moved", place / "models" / MISSION, SETTINGS)
    killed_after(0.0, SEARCH, path, 1, n_evaluated=20)
    moved = Path(shutil.copytree(path, tmp_path / "elsewhere"))

    finished(SEARCH, moved, 1)

    assert digest(moved) == digest(whole)
