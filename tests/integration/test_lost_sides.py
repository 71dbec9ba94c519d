"""A side of a flight, or its server, vanishes: who is left ends, and tells at which tick."""

import re
import signal
import subprocess

import pytest

from tests.integration.network import Witness, bridge, wait_for_tick
from tests.support.rosbridge import process
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
    ("sign", "problem"),
    [
        (signal.SIGKILL, "was lost"),
        pytest.param(signal.SIGSTOP, "was silent for 2 s", marks=slow),
    ],
    ids=["killed", "stopped: its sockets are half open"],
)
def test_a_server_lost_in_mid_run_ends_both_sides_with_8(sign, problem):
    with (
        bridge() as server,
        process(*FLIGHT, "--url", server.url, "--side", "simulation") as simulation,
        process(*FLIGHT, "--url", server.url, "--side", "ci") as ci,
    ):
        wait_for_tick(server.url, 1, 100)
        server.process.send_signal(sign)
        told = [ended_with_8(ci), ended_with_8(simulation)]

    assert all(100 <= tick_of(errors) < 1000 for errors in told)
    assert all(problem in errors for errors in told)


@slow
@pytest.mark.parametrize(
    ("side", "silent"), [("ci", "the simulation"), ("simulation", "the collective intelligence")]
)
def test_a_killed_side_ends_the_other_with_8_and_the_server_goes_on(side, silent):
    with (
        bridge() as server,
        process(*FLIGHT, "--url", server.url, "--side", "simulation") as simulation,
        process(*FLIGHT, "--url", server.url, "--side", "ci") as ci,
    ):
        sides = [ci, simulation] if side == "ci" else [simulation, ci]
        wait_for_tick(server.url, 1, 100)
        sides[1].kill()
        errors = ended_with_8(sides[0])

        assert 100 <= tick_of(errors) < 1000
        assert f"{silent} was silent for 2 s" in errors
        with Witness(server.url) as witness:
            assert witness.is_served()
