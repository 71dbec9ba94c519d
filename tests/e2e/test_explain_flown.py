"""Who flies what ``mrsfi explain`` asks for: workers, servers, somebody else's simulation."""

import json

import pytest

from tests.support.cli import mrsfi, mrsfi_process
from tests.support.planted_world import CHANCY, CHANCY_LATER, external_world
from tests.support.rendezvous import (
    PLANTED,
    harmless,
    write_planted,
    write_rendezvous,
)
from tests.tiers import night, slow

ONE = ("--engine", "reference", "--workers", "1")


@pytest.fixture(scope="module")
def ended(tmp_path_factory):
    """Folder in which a campaign is that was not explained, ``runs/it``."""
    folder = tmp_path_factory.mktemp("ended")
    write_rendezvous(folder)
    evolve = write_planted(folder, [*PLANTED, *harmless(10)])
    mrsfi(*evolve, "--workers", "1", "--no-explain", "--out", "runs/it", cwd=folder)
    return folder


@pytest.fixture(scope="module")
def told(ended):
    """What ``mrsfi explain`` prints of its three most critical, flown in this process."""
    return mrsfi("explain", "runs/it", "--top", "3", *ONE, cwd=ended).stdout


@slow
@pytest.mark.parametrize(
    "options",
    [
        ("--engine", "reference", "--workers", "2"),
        pytest.param(("--engine", "reference", "--dask", "local", "--workers", "2"), marks=night),
        pytest.param(("--engine", "compiled", "--workers", "2"), marks=night),
        pytest.param(("--engine", "rosbridge", "--workers", "1"), marks=night),
        ("--engine", "rosbridge", "--bundle", "--workers", "2"),
    ],
    ids=" ".join,
)
def test_whoever_flies_it_prints_the_same(ended, told, options):
    done = mrsfi_process("explain", "runs/it", "--top", "3", *options, cwd=ended, timeout=240)

    assert done.stdout == told


@slow
@pytest.mark.parametrize(
    ("begins", "what"),
    [
        (CHANCY, "flights with an external simulation may be chance, because they do not repeat "),
        (CHANCY_LATER, "the external simulation does not repeat itself: evaluation 0 had "),
    ],
    ids=["looks before the search", "first flight once more"],
)
def test_that_an_external_simulation_does_not_repeat_itself_stands_wherever_it_is_reported(
    small, url, begins, what
):
    with external_world(url, small, begins):
        printed, found = evolved_elsewhere(small, url)
        refused = mrsfi_process("explain", "out", "--best", cwd=small, expected=7)
        resumed = mrsfi_process("evolve", "--resume", "out", cwd=small)

    caution = found["unrepeated"]
    out = small / "out"
    assert caution.startswith(what)
    assert f"warning: {caution}" in printed.stderr
    assert f"caution   {caution}\n" in printed.stdout
    assert f"**Caution**: {caution}." in (out / "report.md").read_text(encoding="utf-8")
    assert f"Caution: {caution}. " in (out / "report.html").read_text(encoding="utf-8")
    assert f"this campaign cannot be flown again: {caution}; " in refused.stderr
    assert f"caution   {caution}\n" in resumed.stdout
    assert found["weaknesses"] is None
    assert not (out / "causes").exists()


def evolved_elsewhere(small, url):
    """Return what ``mrsfi evolve`` prints and finds on somebody else's simulation."""
    evolve = write_planted(small, PLANTED)[:-2]
    meet = ("--engine", "rosbridge", "--url", url, "--side", "ci", "--bundle")
    done = mrsfi_process(*evolve, *meet, "--out", "out", cwd=small)
    return done, json.loads((small / "out" / "summary.json").read_text(encoding="utf-8"))
