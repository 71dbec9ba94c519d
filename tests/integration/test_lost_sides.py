"""A side of a flight, or its server, vanishes: who is left ends, and tells at which tick."""

import json
import re
import subprocess
from signal import SIGCONT, SIGKILL, SIGSTOP

import pytest

from tests.integration.network import Witness, bridge, wait_for_tick
from tests.support.cli import mrsfi_json, mrsfi_process, without_repetition
from tests.support.rosbridge import process
from tests.support.tree import ROOT
from tests.tiers import slow

FLIGHT = ("simulate", "uuv_sampling", "--engine", "rosbridge", "--timeout", "2")
WITHIN = 15.0
"""Seconds within which a side ends: its time-out, roslibpy's closing, a slow machine."""


def ended_with_8(side: subprocess.Popen[str]) -> str:
    """Require that a side of a flight ends with exit code 8 in time; return what it says."""
    output, errors = side.communicate(timeout=WITHIN)
    assert side.returncode == 8, errors
    assert "Traceback" not in output + errors
    return errors


def tick_of(errors: str) -> int:
    """Return the tick that a message names."""
    (tick,) = re.findall(r"run 1, tick (\d+): ", errors)
    return int(tick)


@slow
@pytest.mark.parametrize(
    ("lost", "sign", "problem"),
    [
        ("server", SIGKILL, "was lost"),
        ("simulation", SIGKILL, "the simulation was silent for 2 s"),
    ],
)
def test_what_is_lost_in_mid_run_ends_the_others_with_8(lost, sign, problem):
    with (
        bridge() as server,
        process(*FLIGHT, "--url", server.url, "--side", "simulation") as simulation,
        process(*FLIGHT, "--url", server.url, "--side", "ci") as ci,
    ):
        parts = {"server": server.process, "simulation": simulation, "ci": ci}
        wait_for_tick(server.url, 1, 100)
        parts[lost].send_signal(sign)
        told = [ended_with_8(parts[side]) for side in ("ci", "simulation") if side != lost]
        if lost != "server":
            with Witness(server.url) as witness:
                assert witness.is_served()

    assert all(100 <= tick_of(errors) < 1000 for errors in told)
    assert all(problem in errors for errors in told)


@slow
@pytest.mark.parametrize("lost", ["server", "ci"])
def test_after_a_silence_in_mid_run_the_simulation_serves_the_next(lost):
    with (
        bridge() as server,
        process(*FLIGHT, "--url", server.url, "--side", "simulation") as simulation,
    ):
        next_ci = (*FLIGHT, "--url", server.url, "--side", "ci", "--json")
        assert "serves at" in simulation.stderr.readline()
        with process(*FLIGHT, "--url", server.url, "--side", "ci") as ci:
            wait_for_tick(server.url, 1, 100)
            if lost == "ci":
                ci.kill()
            else:  # its sockets are half open
                server.process.send_signal(SIGSTOP)
                assert "the simulation was silent for 2 s" in ended_with_8(ci)
            line = simulation.stderr.readline()
        server.process.send_signal(SIGCONT)
        flown = json.loads(mrsfi_process(*next_ci, cwd=ROOT).stdout)

    assert 100 <= tick_of(line) < 1000
    silent = "the collective intelligence or node was silent for 7 s; check that it still runs"
    assert silent in line
    assert line.endswith("; this run is over, the simulation waits for the next\n")
    assert without_repetition(flown) == mrsfi_json("simulate", "uuv_sampling", cwd=ROOT)
