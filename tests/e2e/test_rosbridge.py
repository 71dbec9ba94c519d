"""The command line over rosbridge: two processes, their server, and what happens if one dies."""

import json
import os
import signal

import pytest

from mrsfi_runtime.transport.topics import CLIENTS
from tests.support.cli import (
    MISSION,
    mrsfi_json,
    mrsfi_process,
    stop_specification,
    without_repetition,
)
from tests.support.processes import children, require_end, wait_for
from tests.support.rosbridge import process
from tests.tiers import seeds, slow

ROSBRIDGE = ("--engine", "rosbridge")


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
    here = mrsfi_json("simulate", MISSION, *faults, "--log", "local.log", cwd=place)
    assert without_repetition(flown) == here
    assert (flown["flights"], flown["late"]) == (1, 0)
    assert [goal["broken_in"] for goal in flown["goals"]] == [0] * len(here["goals"])
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
