"""Who flies what ``mrsfi explain`` asks for: workers, servers, somebody else's simulation."""

import json
import sys
from contextlib import contextmanager

import pytest

from tests.support.cli import mrsfi, mrsfi_process
from tests.support.rendezvous import (
    NAME,
    PLANTED,
    harmless,
    write_planted,
    write_rendezvous,
)
from tests.support.rosbridge import process
from tests.tiers import slow

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


@contextmanager
def simulation(url, cwd, *, is_chancy=False):
    """Somebody else's simulation of the mission, at a server."""
    words = ("simulate", NAME, "--engine", "rosbridge", "--side", "simulation", "--url", url)
    program = (sys.executable, "-c", CHANCY) if is_chancy else ()
    with process(*words, cwd=cwd, program=program) as running:
        assert f"serves at {url}" in running.stderr.readline()
        yield


CHANCY = """
import sys
from itertools import count
from mrsfi_runtime import api
from mrsfi_runtime.cli.main import main

initial_state, flown = api.initial_state, count()

def drifted(mission, seed):
    state = initial_state(mission, seed)
    state.robots[1].x += next(flown)
    return state

api.initial_state = drifted
sys.exit(main(sys.argv[1:]))
"""
"""A simulation in which robot b begins elsewhere in every flight, whatever the seed."""


@slow
@pytest.mark.parametrize(
    "options",
    [
        ("--engine", "reference", "--workers", "2"),
        pytest.param(("--engine", "reference", "--dask", "local", "--workers", "2"), marks=slow),
        pytest.param(("--engine", "compiled", "--workers", "2"), marks=slow),
        pytest.param(("--engine", "rosbridge", "--workers", "1"), marks=slow),
        pytest.param(("--engine", "rosbridge", "--bundle", "--workers", "2"), marks=slow),
    ],
    ids=" ".join,
)
def test_whoever_flies_it_prints_the_same(ended, told, options):
    done = mrsfi_process("explain", "runs/it", "--top", "3", *options, cwd=ended, timeout=240)

    assert done.stdout == told


@slow
def test_on_somebody_elses_simulation_nothing_is_explained_unasked_nor_what_flies_otherwise(
    small, url
):
    with simulation(url, small, is_chancy=True):
        printed, found = evolved_elsewhere(small, url)
        refused = mrsfi_process("explain", "out", "--best", cwd=small, expected=7)

    assert found["weaknesses"] is None
    assert "cause " not in printed.stderr
    assert "warning: the simulation does not repeat itself: the first spec" in printed.stderr
    assert printed.stdout.startswith("The 4 most critical of 4 fault specifications\n")
    assert ": flown twice, it had violations " in refused.stderr
    assert "expected what repeats itself" in refused.stderr
    assert not (small / "out" / "causes").exists()


def evolved_elsewhere(small, url):
    """Return what ``mrsfi evolve`` prints and finds on somebody else's simulation."""
    evolve = write_planted(small, PLANTED)[:-2]
    meet = ("--engine", "rosbridge", "--url", url, "--side", "ci", "--bundle")
    done = mrsfi_process(*evolve, *meet, "--out", "out", cwd=small)
    return done, json.loads((small / "out" / "summary.json").read_text(encoding="utf-8"))


@slow
@pytest.mark.turn(0)
def test_somebody_elses_simulation_that_repeats_itself_is_explained_when_asked(ended, small, url):
    one = ("--evaluation", "0", "--json")
    with simulation(url, small):
        printed, _ = evolved_elsewhere(small, url)
        found = mrsfi_process("explain", "out", *one, cwd=small, timeout=240)

    expected = mrsfi("explain", "runs/it", *one, *ONE, cwd=ended)
    (told,), (same,) = (json.loads(each.stdout)["explanations"] for each in (found, expected))
    assert told["is_violated"]
    assert "does not repeat itself" not in printed.stderr
    assert told["columns"] == same["columns"]
    assert told["faults"] == same["faults"]
