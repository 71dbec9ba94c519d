import json
from pathlib import Path
from signal import SIGSTOP
from time import monotonic, sleep
from typing import Any

import pytest

from tests.support.cli import disturbed, mrsfi, mrsfi_json, workspace
from tests.support.cluster import require_dask, scheduler
from tests.support.interrupted import MISSION, evaluations
from tests.tiers import slow

EVOLVE = ("evolve", MISSION, "--engine", "reference", "--population", "8", "--seed", "3")
EVOLVE_SOME = (*EVOLVE, "--generations", "6")
COMPARE = ("compare", MISSION, "--engine", "reference", "--seeds", "1", "--evaluations", "12")
PATIENCE = 120.0  # seconds after which a command counts as hanging


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder with models and generated code of the small mission."""
    require_dask()
    return workspace(tmp_path_factory.mktemp("place"), MISSION)


@pytest.fixture(scope="module")
def whole(place: Path) -> Any:
    """What the campaign finds on one worker of this machine."""
    return mrsfi_json(*EVOLVE_SOME, "--workers", "1", "--out", "runs/whole", cwd=place)


@slow
def test_a_worker_killed_in_mid_campaign_changes_nothing(place, tmp_path, whole):
    out = place / "runs" / "killed"

    with scheduler(tmp_path, 2, has_nannies=True) as cluster:
        cluster.wait_for_workers()
        stalled: list[int] = []

        def kill_one_that_is_at_work(_: int) -> None:
            cluster.workers[0].send(SIGSTOP)
            sleep(1.0)  # now nothing goes on: it has a chunk that the generation waits for
            stalled.append(len(evaluations(out)))
            sleep(1.0)
            stalled.append(len(evaluations(out)))
            cluster.workers[0].kill()

        done = disturbed(
            *EVOLVE_SOME,
            *("--dask", cluster.address, "--out", out, "--json"),
            cwd=place,
            sign="generation 2/",
            disturb=kill_one_that_is_at_work,
        )

    assert done.returncode == 0, done.stderr
    assert stalled[0] == stalled[1] < whole["n_evaluations"]
    assert json.loads(done.stdout)["digest"] == whole["digest"]
    assert f"2 workers of {cluster.address}" in done.stderr
    told = [line for line in done.stderr.splitlines() if not line.startswith("generation ")]
    told = [*dict.fromkeys(line.split()[0] for line in told)]
    assert told == ["campaign", "beyond", "harvest", "drawing"]


@slow
def test_a_comparison_finds_the_same_on_a_local_cluster(place):
    here, there = (
        mrsfi_json(*COMPARE, *options, "--out", f"runs/compared-{number}", cwd=place)
        for number, options in enumerate([("--workers", "1"), ("--dask", "local")])
    )

    assert [run["digest"] for run in there["runs"]] == [run["digest"] for run in here["runs"]]
    assert there["tests"] == here["tests"]


def test_an_address_where_nobody_answers_ends_with_8_soon(place):
    begin = monotonic()

    done = mrsfi(*EVOLVE, "--dask", "tcp://127.0.0.1:1", cwd=place, expected=8)

    assert "--dask tcp://127.0.0.1:1: no scheduler answers" in done.stderr.splitlines()[-1]
    assert monotonic() - begin < PATIENCE / 2


@pytest.mark.parametrize(
    ("options", "expected"),
    [
        (("--dask", "somewhere"), "--dask: found 'somewhere'; expected tcp://HOST:PORT"),
        (("--dask", "tcp://h:1", "--workers", "2"), "--workers 2: makes no sense with --dask tcp:"),
        (("--dask", "local", "--engine", "rosbridge"), "no sense with --engine rosbridge"),
    ],
)
@pytest.mark.parametrize("command", ["evolve", "compare"])
def test_options_that_make_no_sense_end_with_2_and_leave_nothing(place, command, options, expected):
    before = sorted(place.rglob("*"))

    error = mrsfi(command, MISSION, *options, cwd=place, expected=2).stderr

    assert expected in error
    assert sorted(place.rglob("*")) == before
