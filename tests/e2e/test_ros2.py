"""Campaigns with a node of native ROS 2: as over rosbridge, and nothing is left running."""

import os
import signal
import sys

import pytest

from mrsfi_runtime.record.store import CampaignStore
from tests.support.cli import mrsfi_json, mrsfi_process
from tests.support.interrupted import n_rows
from tests.support.nodes import processes_in, require_silence
from tests.support.processes import wait_for
from tests.support.rendezvous import NAME, PLANTED, harmless, write_planted
from tests.support.rosbridge import process
from tests.support.tree import ROOT
from tests.tiers import slow

PATH = os.pathsep.join((str(ROOT), os.environ.get("PYTHONPATH", "")))


@pytest.fixture(autouse=True)
def nodes_are_found(monkeypatch):
    monkeypatch.setenv("PYTHONPATH", PATH)


def node(what, *places):
    """Return the options that start a node of the tests."""
    words = (sys.executable, "-m", f"tests.support.{what}", f"generated/{NAME}", *places)
    return ("--node", " ".join(words), "--side", "injector", "--node-reset", "service")


ROS2 = ("--engine", "ros2", *node("ros2_node", "{domain}", "{seed}"))
ROSBRIDGE = ("--engine", "rosbridge", *node("standin_node", "{url}", "1", "{seed}"))
NODE_LINE = f"{sys.executable} -m tests.support.ros2_node generated/{NAME} "


def nodes(place):
    """Return the nodes that run in a folder."""
    return [pid for pid, line in processes_in(place).items() if line.startswith(NODE_LINE)]


def kill_node(_, place):
    wait_for(lambda: nodes(place))
    os.kill(nodes(place)[0], signal.SIGKILL)


KILLED = {"mrsfi": lambda running, _: running.kill(), "node": kill_node}


def evolve(place, specifications=PLANTED):
    return write_planted(place, specifications)[:-2]


def found(place, out):
    """Return the digest of a campaign, and the flights that followed it."""
    with CampaignStore.open(place / out) as store:
        flights = [(each.specification, each.found) for each in store.flights()]
        return store.digest(), flights


def test_a_flight_has_the_digest_of_the_generated_reactions(small):
    there = mrsfi_json("simulate", NAME, *ROS2, cwd=small)

    require_silence(small)
    assert there["digest"] == mrsfi_json("simulate", NAME, cwd=small)["digest"]


@slow
def test_a_campaign_is_that_over_rosbridge_and_goes_on_as_recorded(small):
    for out, options in (("ros2", ROS2), ("rosbridge", ROSBRIDGE)):
        mrsfi_process(*evolve(small), *options, "--workers", "2", "--out", out, cwd=small)
        require_silence(small)
    again = mrsfi_process("replay", "ros2", "--all", cwd=small)

    assert found(small, "ros2") == found(small, "rosbridge")
    assert found(small, "ros2")[1] != []
    assert again.stdout.startswith("same")


@slow
@pytest.mark.parametrize("what", KILLED)
def test_whatever_is_killed_nothing_is_left_and_the_campaign_ends_the_same(small, what):
    words = (*evolve(small, [*PLANTED, *harmless(8)]), *ROS2, "--no-explain")
    mrsfi_process(*words, "--workers", "1", "--out", "whole", cwd=small)
    words = (*words, "--out", "killed")

    for n_flown in (1, 4):
        with process(*words, "--workers", "2", cwd=small) as running:
            wait_for(lambda n=n_flown: n_rows(small / "killed", "evaluation") >= n, 60)
            KILLED[what](running, small)
            code = running.wait(120)
        assert what == "mrsfi" or code in {0, 8}  # 8: it was killed before its first flight
        require_silence(small)
        words = ("evolve", "--resume", "killed")
    mrsfi_process(*words, "--workers", "2", cwd=small)

    assert found(small, "killed") == found(small, "whole")


def test_the_domain_in_which_nodes_run_by_default_is_an_option(small):
    words = ("simulate", NAME, "--engine", "rosbridge", "--domain", "0")

    refused = mrsfi_process(*words, cwd=small, expected=2)

    assert "--domain 0: needs --engine ros2" in refused.stderr
