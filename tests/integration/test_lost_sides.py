"""A side of a flight, or its server, vanishes: who is left ends, and tells at which tick."""

import re
import subprocess
from signal import SIGKILL, SIGSTOP

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
    ("lost", "sign", "problem"),
    [
        ("server", SIGKILL, "was lost"),
        ("server", SIGSTOP, "was silent for 2 s"),  # its sockets are half open
        ("simulation", SIGKILL, "the simulation was silent for 2 s"),
        ("ci", SIGKILL, "the collective intelligence was silent for 2 s"),
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
