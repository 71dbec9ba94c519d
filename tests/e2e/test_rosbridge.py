"""The command line over rosbridge: two processes, their server, and what happens if one dies."""

import json
import os
import re
import signal

import pytest

from mrsfi_runtime.record.store import CampaignStore
from mrsfi_runtime.transport.topics import CLIENTS
from tests.support.cli import (
    MISSION,
    edit,
    mrsfi_json,
    mrsfi_process,
    stop_specification,
    workspace,
)
from tests.support.interrupted import MISSION as QUICK
from tests.support.processes import children, require_end, wait_for
from tests.support.rosbridge import process
from tests.tiers import night, seeds, slow

ROSBRIDGE = ("--engine", "rosbridge")
TINY = ("--population", "4", "--generations", "1", "--workers", "1")
REFERENCE = ("--engine", "reference")


@pytest.fixture
def quick(tmp_path):
    """Folder with models/ and generated/ of the mission of 200 ticks."""
    return workspace(tmp_path, QUICK)


def bus_json(*arguments, cwd):
    """Run ``mrsfi … --json`` in a process: roslibpy has one kind of transport in each."""
    return json.loads(mrsfi_process(*arguments, "--json", cwd=cwd).stdout)


def has_lines(path, n):
    return path.is_file() and path.read_bytes().count(b"\n") > n


def ended(running):
    """Return exit code and standard error of a process that must end by itself."""
    _, told = running.communicate(timeout=60)
    assert "Traceback" not in told
    return running.returncode, told


def test_a_flight_over_rosbridge_prints_what_the_reference_does(place):
    arguments = ("simulate", MISSION, "--seed", "3")

    flown = bus_json(*arguments, *ROSBRIDGE, cwd=place)

    assert flown == mrsfi_json(*arguments, cwd=place)


@night
def test_logs_traces_and_bags_are_the_same(place):
    faults = ("--faults", stop_specification(place / "models" / MISSION / "stop.xmi", [(9, 99)]))
    for name, options in (("local", ()), ("bus", ROSBRIDGE)):
        files = ("--log", f"{name}.log", "--trace", f"{name}.csv", "--mcap", f"{name}.mcap")
        mrsfi_process("simulate", MISSION, *faults, *files, *options, cwd=place)

    for kind in ("log", "csv", "mcap"):
        assert (place / f"bus.{kind}").read_bytes() == (place / f"local.{kind}").read_bytes()
    events = re.findall(
        "event fault h1 StopRobot on r1 motion: (.*)", (place / "bus.log").read_text()
    )
    assert events == ["starts (9 … 99)", "first changes something", "ends"]


@slow
def test_a_campaign_over_rosbridge_finds_what_the_reference_finds_and_records_how(quick):
    local = mrsfi_json("evolve", QUICK, *TINY, *REFERENCE, "--out", "runs/local", cwd=quick)
    replayed = bus_json("replay", "runs/local", "--best", *ROSBRIDGE, cwd=quick)
    how = {"url": None, "client": "wire", "side": "both"}
    assert replayed["is_same"]
    for options, expected in (
        (("--client", "twisted"), how | {"client": "twisted"}),
        (("--bundle",), how | {"bundle": True}),
    ):
        out = f"runs/{options[0]}"
        found = bus_json("evolve", QUICK, *TINY, *ROSBRIDGE, *options, "--out", out, cwd=quick)
        with CampaignStore.open(quick / out) as store:
            recorded = store.manifest.as_json()

        assert found["digest"] == local["digest"]
        assert (recorded["engine"], recorded["bus"]) == ("rosbridge", expected)


@night
def test_a_project_of_ros_2_flies_the_same_and_records_it(quick):
    local = mrsfi_json("evolve", QUICK, *TINY, *REFERENCE, "--out", "runs/local", cwd=quick)
    (quick / "mrsfi.toml").write_text("[project]\nros = 2\n", encoding="utf-8")

    found = bus_json("evolve", QUICK, *TINY, *ROSBRIDGE, "--out", "runs/bus", cwd=quick)

    with CampaignStore.open(quick / "runs" / "bus") as store:
        assert store.manifest.as_json()["bus"]["ros"] == 2
    assert found["digest"] == local["digest"]


@night
def test_replications_share_one_server(quick, url):
    file = quick / "models" / QUICK / "case_a.toml"
    edit(file, "mission_seed = 1", "mission_seed = 1\nreplications = 2")
    pair = ("--population", "2", "--generations", "1", "--workers", "1")
    meet = ("--url", url, "--bundle")
    digests = [
        bus_json("evolve", QUICK, *pair, *options, "--out", out, cwd=quick)["digest"]
        for out, options in (("runs/local", REFERENCE), ("runs/bus", (*ROSBRIDGE, *meet)))
    ]

    assert digests[0] == digests[1]


@slow
@pytest.mark.parametrize("client", seeds(CLIENTS, 0, 1))
def test_two_sides_meet_on_a_server(place, url, client):
    faults = ("--faults", stop_specification(place / "models" / MISSION / "stop.xmi", [(9, 99)]))
    meet = (*ROSBRIDGE, "--url", url, "--client", client)
    with process("simulate", MISSION, *meet, "--side", "simulation", cwd=place) as simulation:
        sign = simulation.stderr.readline()
        log = ("--log", "ci.log")
        flown = bus_json("simulate", MISSION, *faults, *meet, "--side", "ci", *log, cwd=place)
        os.kill(simulation.pid, signal.SIGINT)
        code, told = ended(simulation)

    assert f"serves at {url}" in sign
    assert flown == mrsfi_json("simulate", MISSION, *faults, "--log", "local.log", cwd=place)
    assert (place / "ci.log").read_bytes() == (place / "local.log").read_bytes()
    assert (code, told) == (130, "mrsfi: interrupted\n")


def test_a_ci_that_is_killed_leaves_no_process_behind(place):
    with process("simulate", MISSION, *ROSBRIDGE, "--trace", "t.csv", cwd=place) as flight:
        wait_for(lambda: has_lines(place / "t.csv", 100))
        orphan = children(flight.pid)[0]
        flight.kill()
        flight.wait()
        require_end([orphan])


def test_a_server_that_is_not_there_ends_with_exit_code_8(place):
    done = mrsfi_process(
        "simulate", MISSION, *ROSBRIDGE, "--url", "ws://127.0.0.1:1", cwd=place, expected=8
    )

    assert "cannot be reached" in done.stderr
    assert "mrsfi bridge" in done.stderr
